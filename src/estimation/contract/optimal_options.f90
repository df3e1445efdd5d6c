!> What the user says of the estimator `optimal`.
module gracecg_estimation_optimal_options
    use gracecg_base_kinds, only: dp
    use gracecg_files_settings, only: settings_t
    use gracecg_observations_parameters, only: find_parameters
    implicit none
    private
    public :: optimal_options_t, describe_optimal, NOISE_GIVEN, NOISE_ESTIMATED
    public :: WAVE_NONE, WAVE_GIVEN, WAVE_SEARCHED

    character(*), parameter :: NOISE_GIVEN = 'given', NOISE_ESTIMATED = 'estimate'
    !! Values of `noise`
    character(*), parameter :: WAVE_NONE = 'none', WAVE_GIVEN = 'given', WAVE_SEARCHED = 'search'
    !! Values of `density_wave`

    !> The settings of group `optimal`.
    type :: optimal_options_t
        character(16) :: noise = NOISE_GIVEN
        !! Noise spectra and star-camera noise of the setup, or estimated from the data. A level that
        !! the setup gives as 0 is estimated in either case
        logical :: estimate_within_limits = .true.
        !! Scale factors and magnetometer bias, which are known within their a-priori sigmas only: so that those of
        !! the offset contain them. The bound considers them in any case
        logical :: estimate_scale_factors = .false.     !! Of the accelerometer; by the bound, too
        logical :: estimate_rod_gain = .false.          !! A factor of all dipole moments
        logical :: estimate_magnetometer_bias = .false. !! Of the flux density; by the bound, too
        character(256) :: also = ''
        !! Names of other parameters that are estimated, as in output, separated by blanks: 'rod_gain_y rod_delay'
        character(16) :: density_wave = WAVE_SEARCHED
        !! A harmonic acceleration along the airflow is estimated: never, with the period given, or
        !! with its period where the residuals show one
        real(dp) :: density_wave_period = 19.9_dp    !! If given, s; the default is that of the built-in cases
        logical :: search_jump = .true.
        !! A jump of the acceleration is estimated where the residuals show one, with estimate_within_limits
    end type optimal_options_t

contains

    !> The group `optimal` of a case file and of setup.nml.
    subroutine describe_optimal(settings, optimal)
        class(settings_t), intent(inout) :: settings
        type(optimal_options_t), intent(inout) :: optimal

        integer, allocatable :: places(:)
        character(:), allocatable :: unknown

        call settings%group('optimal', 'The estimator optimal')
        call settings%text_value('noise', optimal%noise, 'levels of the noise: of the setup, or from the data', &
                                 [character(8) :: NOISE_GIVEN, NOISE_ESTIMATED])
        call settings%logical_value('estimate_within_limits', optimal%estimate_within_limits, &
                                    'scale factors and magnetometer bias, within their a-priori sigmas')
        call settings%logical_value('estimate_scale_factors', optimal%estimate_scale_factors, &
                                    'of the accelerometer, too')
        call settings%logical_value('estimate_rod_gain', optimal%estimate_rod_gain, &
                                    'a factor of all dipole moments, too')
        call settings%logical_value('estimate_magnetometer_bias', optimal%estimate_magnetometer_bias, 'too')
        if (optimal%also /= '' .or. settings%holds('optimal', 'also')) then
            call settings%text_value('also', optimal%also, 'names of parameters that are estimated, too')
            call find_parameters(optimal%also, places, unknown)
            if (unknown /= '') call settings%reject('also', 'no parameter "'//unknown//'" can be estimated; names are those '// &
                                                    'of `estimate --verbose`, as rod_gain_y, rod_delay, acc_turn_x, field_delay')
        end if
        call settings%text_value('density_wave', optimal%density_wave, 'a harmonic acceleration along the '// &
                                 'airflow: with the period given, or searched for in the residuals', &
                                 [character(8) :: WAVE_NONE, WAVE_GIVEN, WAVE_SEARCHED])
        call settings%real_value('density_wave_period', optimal%density_wave_period, 1e-2_dp, 1e6_dp, &
                                 's, if given', unit='s')
        call settings%logical_value('search_jump', optimal%search_jump, 'a jump of the acceleration, too, '// &
                                    'where the residuals show one')
        call settings%end_group()
    end subroutine describe_optimal
end module gracecg_estimation_optimal_options
