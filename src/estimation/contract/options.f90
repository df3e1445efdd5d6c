!> How to estimate: what the estimators can be told beside the observations. The defaults are what an
!> algorithm needs no telling, so `&estimation /` is a whole file of options.
!>
!> A file of options has the groups estimation, optimal and sequential. A case file may have them beside its
!> own groups, a setup.nml beside what the operator knows.
module gracecg_estimation_options
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_files_settings, only: settings_t, FULL_RANGE
    use gracecg_observations_knowledge, only: ESTIMATION_GROUPS
    use gracecg_observations_parameters, only: find_parameters
    implicit none
    private
    public :: estimation_options_t, read_options, options_from_text, options_text, write_options
    public :: check_options, OPTIONS_FILE, optimal_options_t, sequential_options_t, NOISE_GIVEN, NOISE_ESTIMATED
    public :: WAVE_NONE, WAVE_GIVEN, WAVE_SEARCHED, ADAPTIVE, STRAIGHT_LINE

    character(*), parameter :: OPTIONS_FILE = 'options.nml'     !! In the folder of an observation set
    real(dp), parameter :: SMALLEST_GUESS = 0.5_dp      !! Length of a guessed quaternion, before it is normalised
    character(*), parameter :: NOISE_GIVEN = 'given', NOISE_ESTIMATED = 'estimate'
    !! Values of `noise`
    character(*), parameter :: WAVE_NONE = 'none', WAVE_GIVEN = 'given', WAVE_SEARCHED = 'search'
    !! Values of `density_wave`
    character(*), parameter :: ADAPTIVE = 'adaptive', STRAIGHT_LINE = 'straight-line'
    !! Values of `acceleration`

    !> The settings of group `optimal`.
    type :: optimal_options_t
        character(16) :: noise = NOISE_GIVEN
        !! Noise spectra and star-camera noise of the setup, or estimated from the data. A level that
        !! the setup gives as 0 is estimated in either case
        logical :: estimate_within_limits = .true.
        !! Scale factors and magnetometer bias, which are known within their a-priori sigmas only: so that those of
        !! the offset contain them. The bound considers them in any case
        logical :: estimate_scale_factors = .false.     !! Of the accelerometer; by the bound, too
        logical :: estimate_rod_gain = .false.          !! A factor of all dipole moments; of each torquer
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

    !> The settings of group `sequential`.
    type :: sequential_options_t
        character(16) :: acceleration = ADAPTIVE
        !! Beside bias and drift: a parabola along the airflow, and second-order Gauss-Markov processes whose
        !! size, period and damping the likelihood of the innovations tells (adaptive); nothing (straight-line)
        real(dp) :: likelihood_gain = 10            !! Of 2 ln L, that an adaptive process must bring
        real(dp) :: shared_part = 0.013_dp
        !! Of the process found in one axis the others see a part, as drag acts along the airflow. Its
        !! standard deviation about that of the air that turns with the Earth: 0.013 for the eastward wind of
        !! HWM93 along polar orbits, 100 m/s RMS (data/wind_hwm93_1989-01-02.txt)
        logical :: estimate_within_limits = .true.
        !! Scale factors and magnetometer bias, which are known within their a-priori sigmas only
        real(dp) :: edit_sigma = 5                  !! A sample farther off is edited, standard deviations
    end type sequential_options_t

    !> How to estimate. Nothing here is of the satellite or its instruments: that is operator_knowledge_t.
    type :: estimation_options_t
        logical :: covariance = .true.
        !! Propagate the covariance of the offset and check the fit against noise and torque; no key of a file.
        !! Of the report's estimators this costs as much as the estimate itself. optimal and sequential have
        !! their covariance from the fit and give it in any case: they leave out the checks alone
        logical :: history = .false.    !! Keep every iteration in the solution; no key of a file
        real(dp) :: guess_quaternion(4) = 0         !! First guess of the attitude at the epoch, inertial to body
        !! (normalised before use); 0: from the star-camera samples
        real(dp) :: guess_angular_velocity(3) = 0   !! At the epoch, body axes, rad/s; 0: from those samples
        real(dp) :: guess_offset(3) = 1e-5_dp       !! d*, body axes, m
        real(dp) :: largest_offset = 1e-2_dp
        !! Of each component, m: one that is beyond it by five sigmas is refused, unless covariance is false
        logical :: test_beliefs = .true.
        !! Test what the setup says against the data, if the fit is checked at all
        real(dp) :: wanted_accuracy = 5e-5_dp
        !! Of each component, m: a wrong belief that could move one farther without being seen is said to be untested
        real(dp) :: accelerometer_weight(3) = [10.0_dp, 1.0_dp, 145.0_dp]
        !! Of its axes, in the report's estimators: CSR-TM-00-01 section 6.1
        real(dp) :: star_camera_weight = 1          !! Of every attitude component in ASSEST: ibid.
        real(dp) :: combined_star_camera_weight = 90    !! The same in ASCFEST and ASCREST: ibid.
        type(optimal_options_t) :: optimal = optimal_options_t()              !! Of the estimator `optimal`
        type(sequential_options_t) :: sequential = sequential_options_t()     !! Of the estimator `sequential`
    end type estimation_options_t

contains

    !> Reads a file of options, or those in a file with groups of others. Fails, with file, line and key, for
    !> a key that is not known and a value that is not allowed; a group that is not known is refused in a
    !> file of options alone: in another one, whose groups they are has to see to that.
    subroutine read_options(path, options, error, beside)
        character(*), intent(in) :: path        !! Of the namelist file
        type(estimation_options_t), intent(out) :: options
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: beside !! The file has groups of others, too; absent: options alone

        type(settings_t) :: reader

        call reader%open(path, error)
        if (.not. allocated(error)) call take_options(reader, options, error, beside)
    end subroutine read_options

    !> The same from a text; `name` stands for the file in messages.
    subroutine options_from_text(text, name, options, error, beside)
        character(*), intent(in) :: text, name  !! Content; what stands for the file in messages
        type(estimation_options_t), intent(out) :: options
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: beside !! As of read_options

        type(settings_t) :: reader

        call reader%open_text(text, name, error)
        if (.not. allocated(error)) call take_options(reader, options, error, beside)
    end subroutine options_from_text

    subroutine take_options(reader, options, error, beside)
        type(settings_t), intent(inout) :: reader
        type(estimation_options_t), intent(inout) :: options
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: beside

        call describe_options(reader, options)
        if (present(beside)) then
            call reader%finish(error, only=ESTIMATION_GROUPS)
        else
            call reader%finish(error)
        end if
    end subroutine take_options

    !> The text of a file of options: what `read_options` reads. Fails when a number is not finite.
    subroutine options_text(options, text, error)
        type(estimation_options_t), intent(in) :: options
        character(:), allocatable, intent(out) :: text  !! Lines separated by line feeds
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: writer
        type(estimation_options_t) :: copy

        copy = options
        call describe_options(writer, copy)
        call writer%to_text(text, error)
    end subroutine options_text

    !> Fails for options that no file could give: a number out of its range, a text that is none of the choices. So do all
    !> estimates.
    subroutine check_options(options, error)
        type(estimation_options_t), intent(in) :: options
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: checker
        type(estimation_options_t) :: copy

        copy = options
        call checker%check_only()
        call take_options(checker, copy, error)
    end subroutine check_options

    !> Writes a file of options. Fails when a number is not finite or the file cannot be written.
    subroutine write_options(path, options, comments, error)
        character(*), intent(in) :: path            !! Of the file; an existing one is replaced
        type(estimation_options_t), intent(in) :: options
        character(*), intent(in) :: comments(:)     !! Its first lines; may be none
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: writer
        type(estimation_options_t) :: copy
        integer :: i

        do i = 1, size(comments)
            call writer%comment(trim(comments(i)))
        end do
        copy = options
        call describe_options(writer, copy)
        call writer%save(path, error)
    end subroutine write_options

    !> Every option with its unit and range.
    subroutine describe_options(settings, options)
        type(settings_t), intent(inout) :: settings
        type(estimation_options_t), intent(inout) :: options

        call settings%group('estimation', 'First guesses and weights of the estimators')
        call settings%real_values('guess_quaternion', options%guess_quaternion, -1.0_dp, 1.0_dp, &
                                  'at the epoch, inertial to body, scalar last; 0: from the star-camera samples')
        if (any(abs(options%guess_quaternion) > 0) .and. .not. norm2(options%guess_quaternion) > SMALLEST_GUESS) &
            call settings%reject('guess_quaternion', 'is too far from unit length')
        call settings%real_values('guess_angular_velocity', options%guess_angular_velocity, -1.0_dp, 1.0_dp, &
                                  'rad/s, at the epoch; 0: from the star-camera samples', unit='rad/s')
        call settings%real_values('guess_offset_mm', options%guess_offset, -1000.0_dp, 1000.0_dp, 'mm', &
                                  1e-3_dp, 'mm')
        call settings%real_value('largest_offset_mm', options%largest_offset, 1e-3_dp, 1e6_dp, &
                                 'mm, of a component: estimates beyond it are not plausible and refused', 1e-3_dp, 'mm')
        call settings%logical_value('test_beliefs', options%test_beliefs, 'what the setup says, against the data')
        call settings%real_value('wanted_accuracy_mm', options%wanted_accuracy, 1e-6_dp, 1e3_dp, &
                                 'mm, of a component: beliefs that could move it farther unseen are untested', 1e-3_dp, 'mm')
        call settings%real_values('accelerometer_weight', options%accelerometer_weight, tiny(1.0_dp), &
                                  FULL_RANGE, 'of the axes')
        call settings%real_value('star_camera_weight', options%star_camera_weight, tiny(1.0_dp), FULL_RANGE, &
                                 'of every attitude component, ASSEST')
        call settings%real_value('combined_star_camera_weight', options%combined_star_camera_weight, &
                                 tiny(1.0_dp), FULL_RANGE, 'of every attitude component, ASCFEST and ASCREST')
        call settings%end_group()
        call describe_optimal(settings, options%optimal)
        call describe_sequential(settings, options%sequential)
    end subroutine describe_options

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
                                    'a factor of all dipole moments, of each torquer one, too')
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

    !> The group `sequential` of a case file and of setup.nml.
    subroutine describe_sequential(settings, sequential)
        class(settings_t), intent(inout) :: settings
        type(sequential_options_t), intent(inout) :: sequential

        call settings%group('sequential', 'The estimator sequential: non-gravitational acceleration, editing')
        call settings%text_value('acceleration', sequential%acceleration, &
                                 'beside the straight line: a parabola and processes found from the data, or nothing', &
                                 [character(13) :: ADAPTIVE, STRAIGHT_LINE])
        call settings%real_value('likelihood_gain', sequential%likelihood_gain, 0.0_dp, 1e6_dp, &
                                 'of 2 ln L, that a process found from the data must bring')
        call settings%real_value('shared_part', sequential%shared_part, 1e-6_dp, 10.0_dp, &
                                 'sigma of the part of a process found in one axis that the others see, about that '// &
                                 'of an acceleration along the airflow')
        call settings%logical_value('estimate_within_limits', sequential%estimate_within_limits, &
                                    'scale factors and magnetometer bias, within their a-priori sigmas')
        call settings%real_value('edit_sigma', sequential%edit_sigma, 3.0_dp, 1e6_dp, &
                                 'samples farther off than so many standard deviations are edited')
        call settings%end_group()
    end subroutine describe_sequential
end module gracecg_estimation_options
