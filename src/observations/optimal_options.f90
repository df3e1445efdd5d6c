!> What the user says of the estimator `optimal` and of the limits within which the operator knows
!> satellite and instruments.
!>
!> The standard deviations serve twice: as a-priori knowledge of the parameters that are estimated,
!> and, for those that are not, in the consider covariance of the bound. Their defaults are the true
!> errors of the simulation of CSR-TM-00-01, section 5.2, where it has such an error (scale factors,
!> magnetometer bias); the others are said below.
module gracecg_observations_optimal_options
    use gracecg_base_kinds, only: dp
    use gracecg_files_settings, only: settings_t
    implicit none
    private
    public :: optimal_settings_t, describe_optimal, NOISE_GIVEN, NOISE_ESTIMATED
    public :: WAVE_NONE, WAVE_GIVEN, WAVE_SEARCHED

    character(*), parameter :: NOISE_GIVEN = 'given', NOISE_ESTIMATED = 'estimate'
    !! Values of `noise`
    character(*), parameter :: WAVE_NONE = 'none', WAVE_GIVEN = 'given', WAVE_SEARCHED = 'search'
    !! Values of `density_wave`

    !> The settings of group `optimal`.
    type :: optimal_settings_t
        character(16) :: noise = NOISE_GIVEN
        !! Noise spectra and star-camera noise of the setup, or estimated from the data. A level that
        !! the setup gives as 0 is estimated in either case
        logical :: estimate_scale_factors = .false.     !! Of the accelerometer
        logical :: estimate_rod_gain = .false.          !! A factor of all dipole moments
        logical :: estimate_magnetometer_bias = .false. !! Of the flux density
        character(16) :: density_wave = WAVE_SEARCHED
        !! A harmonic acceleration along the airflow is estimated: never, with the period given, or
        !! with its period where the residuals show one
        real(dp) :: density_wave_period = 12    !! If given, s
        real(dp) :: sigma_scale_factors(3) = [0.0101_dp, 0.0159_dp, 0.0119_dp]
        !! Of the accelerometer's scale factors, relative
        real(dp) :: sigma_rod_gain = 0.005_dp
        !! Of the dipole moment of the rods, relative; not in the report
        real(dp) :: sigma_magnetometer_bias(3) = [50e-9_dp, 30e-9_dp, 25e-9_dp]     !! T
        real(dp) :: sigma_inertia = 1e-3_dp
        !! Of each element of the inertia tensor, in units of its smallest moment; not in the report
        real(dp) :: sigma_torque = 1e-6_dp
        !! Of the change of the unmodelled torque from the beginning to the end of the arc, N m: a
        !! twentieth of the air's and the Sun's torque of some 2e-5 N m in Figures 5.6 and 5.7
    end type optimal_settings_t

contains

    !> The group `optimal` of a case file and of setup.nml.
    subroutine describe_optimal(settings, optimal)
        class(settings_t), intent(inout) :: settings
        type(optimal_settings_t), intent(inout) :: optimal

        real(dp), parameter :: SMALLEST = 1e-12_dp

        call settings%group('optimal', 'The estimator optimal, and the limits of knowledge for the bound')
        call settings%text_value('noise', optimal%noise, 'levels of the noise: of the setup, or from the data', &
                                 [character(8) :: NOISE_GIVEN, NOISE_ESTIMATED])
        call settings%logical_value('estimate_scale_factors', optimal%estimate_scale_factors, &
                                    'of the accelerometer, too')
        call settings%logical_value('estimate_rod_gain', optimal%estimate_rod_gain, &
                                    'a factor of all dipole moments, too')
        call settings%logical_value('estimate_magnetometer_bias', optimal%estimate_magnetometer_bias, 'too')
        call settings%text_value('density_wave', optimal%density_wave, 'a harmonic acceleration along the '// &
                                 'airflow: with the period given, or searched for in the residuals', &
                                 [character(8) :: WAVE_NONE, WAVE_GIVEN, WAVE_SEARCHED])
        call settings%real_value('density_wave_period', optimal%density_wave_period, 1e-2_dp, 1e6_dp, &
                                 's, if given', unit='s')
        call settings%real_values('sigma_scale_factors', optimal%sigma_scale_factors, SMALLEST, 1.0_dp, &
                                  'of the accelerometer, relative, a priori')
        call settings%real_value('sigma_rod_gain', optimal%sigma_rod_gain, SMALLEST, 1.0_dp, &
                                 'relative, a priori')
        call settings%real_values('sigma_magnetometer_bias', optimal%sigma_magnetometer_bias, SMALLEST, &
                                  1e-3_dp, 'T, a priori', unit='T')
        call settings%real_value('sigma_inertia', optimal%sigma_inertia, 0.0_dp, 1.0_dp, &
                                 'of the elements of the inertia tensor, in its smallest moment')
        call settings%real_value('sigma_torque', optimal%sigma_torque, 0.0_dp, 1.0_dp, &
                                 'N m, of the change of the unmodelled torque over the arc', unit='N m')
        call settings%end_group()
    end subroutine describe_optimal
end module gracecg_observations_optimal_options
