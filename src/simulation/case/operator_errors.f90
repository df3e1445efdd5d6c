!> What the operator of a simulated satellite goes by, and where that is wrong: group operator of a case file.
!>
!> One table, SOURCES, says of what there is an error. Every source has a value and a standard deviation:
!> the value is always in the operator's knowledge, with a deviation the error is drawn anew for every run,
!> value + sigma times a normal number. gracecg_simulation_operator_view derives the knowledge.
module gracecg_simulation_operator_errors
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: DEGREE, ARCSECOND
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_files_settings, only: settings_t
    use gracecg_observations_knowledge, only: a_priori_t, NO_FIELD_MODEL
    implicit none
    private
    public :: operator_t, error_source_t, AS_TRUTH, SOURCES
    public :: describe_operator, errors_of, drawn_operator
    public :: INERTIA, PRINCIPAL_MOMENTS, PRINCIPAL_AXES, MASS, COMMON_ROD_GAIN, ROD_GAIN, ROD_DIRECTION, ROD_DELAY, &
        ACCELEROMETER_SCALE, ACCELEROMETER_DELAY, ACCELEROMETER_NOISE, STAR_CAMERA_NOISE, MOUNTING, &
        MAGNETOMETER_BIAS, TORQUE_CHANGE, ORBIT_POSITION, ORBIT_VELOCITY, ORBIT_TIME

    !> Something that an operator may be wrong about.
    type :: error_source_t
        character(20) :: name           !! Key of the group operator; name_sigma is its standard deviation
        integer :: components           !! How many numbers it has
        character(7) :: unit            !! In files
        real(dp) :: factor              !! From that unit to SI
        real(dp) :: exact               !! Value of a right belief: 0, of a factor 1
        real(dp) :: size
        !! An error of ordinary size, in that unit: what `gracecg errors` takes where nothing better is known
        real(dp) :: most                !! Greatest value allowed, in that unit
        character(110) :: meaning       !! For files
    end type error_source_t

    !> Places of the sources in SOURCES. They name streams of random numbers, too: a new one goes to the end
    integer, parameter :: INERTIA = 1, PRINCIPAL_MOMENTS = 2, PRINCIPAL_AXES = 3, MASS = 4, COMMON_ROD_GAIN = 5, &
        ROD_GAIN = 6, ROD_DIRECTION = 7, ROD_DELAY = 8, ACCELEROMETER_SCALE = 9, ACCELEROMETER_DELAY = 10, &
        ACCELEROMETER_NOISE = 11, STAR_CAMERA_NOISE = 12, MOUNTING = 13, MAGNETOMETER_BIAS = 14, &
        TORQUE_CHANGE = 15, ORBIT_POSITION = 16, ORBIT_VELOCITY = 17, ORBIT_TIME = 18

    character(*), parameter :: AS_TRUTH = 'truth'   !! The field model is that of the group earth
    integer, parameter :: MOST_COMPONENTS = 6
    integer, parameter :: FIRST_STREAM = 100    !! Of random numbers: source i draws from FIRST_STREAM + i

    !> All sources, in the order of their places
    type(error_source_t), parameter :: SOURCES(18) = [ &
        error_source_t('inertia', 6, '', 1.0_dp, 0.0_dp, 1e-3_dp, 1.0_dp, &
                       'of the elements xx, yy, zz, xy, yz, zx, in units of the smallest moment'), &
        error_source_t('principal_moments', 3, '', 1.0_dp, 0.0_dp, 1e-3_dp, 1.0_dp, &
                       'relative, smallest moment first'), &
        error_source_t('principal_axes_deg', 3, 'deg', DEGREE, 0.0_dp, 0.01_dp, 180.0_dp, &
                       'deg, turn of the principal axes about x, y, z'), &
        error_source_t('mass', 1, '', 1.0_dp, 0.0_dp, 1e-3_dp, 0.9_dp, 'relative'), &
        error_source_t('common_rod_gain', 1, '', 1.0_dp, 0.0_dp, 5e-3_dp, 1.0_dp, &
                       'relative, of all rods alike'), &
        error_source_t('rod_gain', 3, '', 1.0_dp, 0.0_dp, 5e-3_dp, 1.0_dp, 'relative, of each rod'), &
        error_source_t('rod_direction_deg', 6, 'deg', DEGREE, 0.0_dp, 0.1_dp, 180.0_dp, &
                       'deg, of the x rod about y and z, of the y rod about z and x, of the z rod about x and y'), &
        error_source_t('rod_delay', 3, 's', 1.0_dp, 0.0_dp, 5e-4_dp, 10.0_dp, 's, of each rod'), &
        error_source_t('accelerometer_scale', 3, '', 1.0_dp, 0.0_dp, 1e-2_dp, 0.9_dp, 'factor minus 1, of each axis'), &
        error_source_t('accelerometer_delay', 1, 's', 1.0_dp, 0.0_dp, 1e-3_dp, 0.1_dp, &
                       's, by which the time tags are believed to be late'), &
        error_source_t('accelerometer_noise', 3, '', 1.0_dp, 1.0_dp, 0.1_dp, 1e6_dp, &
                       'factor, believed level of the noise spectrum by the true one, of each axis'), &
        error_source_t('star_camera_noise', 3, '', 1.0_dp, 1.0_dp, 0.1_dp, 1e6_dp, &
                       'factor, believed noise by the true one, about camera x, y and boresight'), &
        error_source_t('mounting_arcsec', 6, 'arcsec', ARCSECOND, 0.0_dp, 20.0_dp, 648000.0_dp, &
                       'arcsec, turn of star-camera head 1 about its x, y and boresight, then of head 2'), &
        error_source_t('magnetometer_bias_nt', 3, 'nT', 1e-9_dp, 0.0_dp, 30.0_dp, 1e6_dp, &
                       'nT, believed bias of each axis'), &
        error_source_t('torque_change', 3, 'N m', 1.0_dp, 0.0_dp, 1e-6_dp, 1.0_dp, &
                       'N m, believed change of the unmodelled torque over the arc'), &
        error_source_t('orbit_position', 3, 'm', 1.0_dp, 0.0_dp, 10.0_dp, 1e6_dp, &
                       'm, radial, along the orbit and across it'), &
        error_source_t('orbit_velocity', 3, 'm/s', 1.0_dp, 0.0_dp, 0.01_dp, 1e3_dp, &
                       'm/s, radial, along the orbit and across it: grows with time'), &
        error_source_t('orbit_time', 1, 's', 1.0_dp, 0.0_dp, 0.01_dp, 10.0_dp, &
                       's, by which the time tags of the orbit are late')]

    !> The operator of a case.
    type :: operator_t
        integer :: head = 1             !! Star-camera head whose quaternions are used
        character(16) :: field_model = AS_TRUTH     !! Geomagnetic field where the magnetometer fails
        type(a_priori_t) :: a_priori    !! How well the operator believes to know things
        real(dp) :: value(MOST_COMPONENTS, size(SOURCES)) = spread(SOURCES%exact, 1, MOST_COMPONENTS)
        !! Errors in the knowledge, (component, source), SI
        real(dp) :: sigma(MOST_COMPONENTS, size(SOURCES)) = 0
        !! Standard deviations of what is drawn for every run
    end type operator_t

contains

    !> The group operator of a case file.
    subroutine describe_operator(settings, operator)
        class(settings_t), intent(inout) :: settings
        type(operator_t), intent(inout) :: operator

        type(error_source_t) :: source
        real(dp) :: low
        integer :: i, n

        call settings%group('operator', 'What the operator knows wrongly; NAME_sigma: drawn anew for every run')
        call settings%text_value('field_model', operator%field_model, 'where the magnetometer fails', &
                                 [character(6) :: AS_TRUTH, 'igrf95', 'igrf14', NO_FIELD_MODEL])
        do i = 1, size(SOURCES)
            source = SOURCES(i)
            n = source%components
            low = merge(1/source%most, -source%most, source%exact > 0)
            call settings%real_values(trim(source%name), operator%value(:n, i), low, source%most, &
                                      trim(source%meaning), source%factor, trim(source%unit))
            call settings%real_values(trim(source%name)//'_sigma', operator%sigma(:n, i), 0.0_dp, source%most, &
                                      'standard deviation', source%factor, trim(source%unit))
        end do
        call settings%end_group()
    end subroutine describe_operator

    !> The errors of one source, SI; 0 (of a factor 1) by default.
    pure function errors_of(operator, source) result(values)
        type(operator_t), intent(in) :: operator
        integer, intent(in) :: source       !! Its place in SOURCES
        real(dp) :: values(SOURCES(source)%components)

        values = operator%value(:SOURCES(source)%components, source)
    end function errors_of

    !> The operator of one run: what has a standard deviation is drawn. Each source draws from a stream of its
    !> own, so that its errors are the same whatever else is drawn. A factor does not fall below a tenth of its
    !> value.
    function drawn_operator(operator, seed, case_number, satellite, run) result(drawn)
        type(operator_t), intent(in) :: operator
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: case_number, satellite, run    !! The names of a stream, see new_stream
        type(operator_t) :: drawn

        type(random_stream_t) :: stream
        real(dp) :: normal(MOST_COMPONENTS)
        integer :: i

        drawn = operator
        drawn%sigma = 0
        do i = 1, size(SOURCES)
            if (.not. any(operator%sigma(:, i) > 0)) cycle
            stream = new_stream(seed, case_number, satellite, run, FIRST_STREAM + i)
            call stream%normals(normal)
            drawn%value(:, i) = operator%value(:, i) + operator%sigma(:, i)*normal
            if (SOURCES(i)%exact > 0) drawn%value(:, i) = max(drawn%value(:, i), operator%value(:, i)/10)
        end do
    end function drawn_operator
end module gracecg_simulation_operator_errors
