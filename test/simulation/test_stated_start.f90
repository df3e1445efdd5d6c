!> The initial state of a case from what operators have: elements of Kepler, an Earth-fixed state, two-line elements, an
!> attitude to the Earth.
module test_stated_start
    use vocabulary
    use calibrations
    use gracecg_base_quaternion, only: rotation_matrix, rotation_angle_between
    use gracecg_base_text, only: real_text
    use gracecg_environment_time, only: utc_t, utc_plus, modified_julian_day
    use gracecg_simulation_case, only: case_from_text, case_text
    use gracecg_simulation_dynamics, only: satellite_dynamics_t
    use gracecg_simulation_stated_start, only: kepler_state, tle_state
    implicit none
    private
    public :: collect_stated_start

    character(*), parameter :: LF = achar(10), QUOTE = achar(39)
    character(*), parameter :: NADIR = 'attitude = '//QUOTE//'nadir'//QUOTE
    !> Vallado, Crawford, Hujsak, Kelso, AIAA 2006-6753: the first of the verification cases of SGP4
    character(69), parameter :: VANGUARD(2) = [ &
        '1 00005U 58002B   00179.78495062  .00000023  00000-0  28098-4 0  4753', &
        '2 00005  34.2682 348.7242 1859667 331.7664  19.3264 10.82419157413667']
    !> Of an orbit as GRACE's; its states by the program sgp4 of Vallado and Rhodes, version 2.24
    character(69), parameter :: POLAR(2) = [ &
        '1 43476U 18047A   24001.50000000  .00010000  00000-0  25000-3 0  9997', &
        '2 43476  88.9800 120.1234 0016500 110.2500 250.0100 15.24050000310013']
    character(*), parameter :: KEPLER = "orbit = 'kepler', semi_major_axis_km = 6870, eccentricity = 0.001, "// &
        "inclination_deg = 89, node_deg = 120, perigee_deg = 90, mean_anomaly_deg = 10"
    character(*), parameter :: BY_LINES = "orbit = 'tle', tle_1 = '"//POLAR(1)//"', tle_2 = '"//POLAR(2)//"'"

contains

    subroutine collect_stated_start(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('elements-of-kepler', test_kepler), &
                    new_unittest('two-line-elements', test_tle), &
                    new_unittest('earth-fixed', test_earth_fixed), &
                    new_unittest('tle-meets-earth-fixed', test_tle_case), &
                    new_unittest('attitude-to-the-earth', test_attitude), &
                    new_unittest('written-as-a-state', test_written), &
                    new_unittest('refusals', test_refusals)]
    end subroutine collect_stated_start

    !> A case whose group truth has some lines.
    subroutine state_case(truth, case, failure, day)
        character(*), intent(in) :: truth
        type(case_t), intent(out) :: case
        type(error_t), allocatable, intent(out) :: failure
        character(*), intent(in), optional :: day
        character(10) :: date

        date = '2024-01-01'
        if (present(day)) date = day
        call case_from_text("&calibration epoch = '"//date//"T12:00:00', duration = 60 /"//LF// &
                            "&mass_properties mass = 100, moments_of_inertia = 8, 9, 10 /"//LF// &
                            "&truth"//LF//truth//LF//"/", 'own.nml', case, failure)
    end subroutine state_case

    !> Vallado, Fundamentals of Astrodynamics, example 2-6: p = 11067.790 km, true anomaly 92.335 deg; and energy and angular
    !> momentum are those of the elements.
    subroutine test_kepler(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: E = 0.83285_dp, TRUE_ANOMALY = 92.335_dp*DEGREE
        real(dp) :: eccentric, a, position(3), velocity(3)

        a = 11067.790e3_dp/(1 - E**2)
        eccentric = 2*atan(sqrt((1 - E)/(1 + E))*tan(TRUE_ANOMALY/2))
        call kepler_state([a, E, 87.87_dp*DEGREE, 227.89_dp*DEGREE, 53.38_dp*DEGREE, eccentric - E*sin(eccentric)], position, &
                          velocity)
        call check(error, norm2(position - [6525.344e3_dp, 6861.535e3_dp, 6449.125e3_dp]) < 50)
        call check(error, norm2(velocity - [4902.276_dp, 5533.124_dp, -1975.709_dp]) < 0.05_dp)
        call check(error, norm2(velocity)**2/2 - EARTH_GM/norm2(position), -EARTH_GM/(2*a), thr=1e-3_dp)
        call check(error, norm2(cross(position, velocity)), sqrt(EARTH_GM*a*(1 - E**2)), thr=1.0_dp)
    end subroutine test_kepler

    subroutine test_tle(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: position(3), velocity(3)
        type(error_t), allocatable :: failure
        type(utc_t) :: epoch

        epoch = utc_t(modified_julian_day(2000, 6, 27), 0.78495062_dp*86400)
        call tle_state(VANGUARD, epoch, position, velocity, failure)
        if (failed(error, failure)) return
        call check(error, norm2(position - [7022465.29266_dp, -1400082.96755_dp, 39.95155_dp]) < 0.1_dp)
        call check(error, norm2(velocity - [1893.841015_dp, 6405.893759_dp, 4534.807250_dp]) < 1e-4_dp)
        epoch = utc_t(modified_julian_day(2024, 1, 1), 43200.0_dp)
        call tle_state(POLAR, utc_plus(epoch, 2592.0_dp), position, velocity, failure)
        if (failed(error, failure)) return
        call check(error, norm2(position - [3300968.2639_dp, -5753078.5681_dp, 1775214.5067_dp]) < 100)
        call tle_state(POLAR, utc_plus(epoch, 86400.0_dp), position, velocity, failure)
        if (failed(error, failure)) return
        call check(error, norm2(position - [-525782.5863_dp, 668722.5340_dp, 6800966.3628_dp]) < 100)
        call check(error, norm2(velocity - [3770.17736_dp, -6566.67380_dp, 930.20871_dp]) < 0.2_dp)
    end subroutine test_tle

    !> A state turned into Earth-fixed axes and back is the same.
    subroutine test_earth_fixed(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case, again
        type(satellite_dynamics_t) :: dynamics
        type(error_t), allocatable :: failure
        real(dp) :: position(3), velocity(3), to_earth(3, 3)

        call state_case(KEPLER//LF//NADIR, case, failure)
        if (.not. allocated(failure)) call build_dynamics_without_air(case, dynamics, failure)
        if (failed(error, failure)) return
        to_earth = dynamics%earth%from_inertial(0.0_dp)
        position = matmul(to_earth, case%position)
        velocity = (matmul(dynamics%earth%from_inertial(0.5_dp), case%position + case%velocity/2) - &
                    matmul(dynamics%earth%from_inertial(-0.5_dp), case%position - case%velocity/2))
        call state_case("orbit = 'earth-fixed', position = "//numbers(position)//", velocity = "//numbers(velocity)//LF//NADIR, &
                        again, failure)
        if (failed(error, failure)) return
        call check(error, norm2(again%position - case%position) < 1e-6_dp)
        call check(error, norm2(again%velocity - case%velocity) < 1e-4_dp)
    end subroutine test_earth_fixed

    subroutine build_dynamics_without_air(case, dynamics, failure)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(out) :: dynamics
        type(error_t), allocatable, intent(out) :: failure
        type(case_t) :: airless

        airless = case
        airless%density_model = 'none'
        airless%field_model = 'igrf14'
        call make_dynamics(airless, dynamics)
    end subroutine build_dynamics_without_air

    function numbers(values) result(text)
        real(dp), intent(in) :: values(3)
        character(:), allocatable :: text

        text = real_text(values(1))//', '//real_text(values(2))//', '//real_text(values(3))
    end function numbers

    !> Precession since 2000, 0.33 deg or 38 km, is taken into account: the latitude of the state is that of the elements.
    subroutine test_tle_case(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(satellite_dynamics_t) :: dynamics
        type(error_t), allocatable :: failure
        real(dp) :: position(3), of_date(3), velocity(3)

        call state_case(BY_LINES//LF//NADIR, case, failure)
        if (.not. allocated(failure)) call build_dynamics_without_air(case, dynamics, failure)
        if (.not. allocated(failure)) call tle_state(POLAR, case%epoch, of_date, velocity, failure)
        if (failed(error, failure)) return
        position = matmul(dynamics%earth%from_inertial(0.0_dp), case%position)
        call check(error, position(3), of_date(3), thr=50.0_dp)
        call check(error, norm2(case%position), norm2(of_date), thr=1e-3_dp)
        call check(error, norm2(case%position - of_date) > 20e3_dp)
        call check(error, norm2(case%velocity), norm2(velocity), thr=1e-6_dp)
    end subroutine test_tle_case

    !> z to the Earth, x along the velocity or against it, turning with the orbit: within the report's pitch of its own.
    subroutine test_attitude(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case, back, report
        type(error_t), allocatable :: failure
        real(dp) :: axes(3, 3)

        call state_case(KEPLER//LF//NADIR, case, failure)
        if (failed(error, failure)) return
        axes = rotation_matrix(case%quaternion)
        call check(error, norm2(axes(3, :) + unit(case%position)) < 1e-12_dp)
        call check(error, dot_product(axes(1, :), unit(case%velocity)) > 0.99999_dp)
        call check(error, norm2(case%angular_velocity - [0.0_dp, -norm2(cross(case%position, case%velocity))/ &
                                                         sum(case%position**2), 0.0_dp]) < 1e-15_dp)
        call state_case(KEPLER//LF//"attitude = 'nadir-backward'", back, failure)
        if (failed(error, failure)) return
        call check(error, norm2(back%angular_velocity + case%angular_velocity) < 1e-15_dp)
        call take_case('front-1', report)
        call state_case('position = '//numbers(report%position)//', velocity = '//numbers(report%velocity)//LF// &
                        merge("attitude = 'nadir-backward'", "attitude = 'nadir'         ", report%angular_velocity(2) > 0), &
                        case, failure)
        if (failed(error, failure)) return
        call check(error, rotation_angle_between(case%quaternion, report%quaternion) < 1.2_dp*DEGREE)
        call check(error, norm2(case%angular_velocity - report%angular_velocity) < 5e-6_dp)
    end subroutine test_attitude

    !> What is written has position, velocity and quaternion, and reads back exactly.
    subroutine test_written(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case, again
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call state_case(BY_LINES//LF//NADIR, case, failure)
        if (.not. allocated(failure)) call case_text(case, text, failure)
        if (.not. allocated(failure)) call case_from_text(text, 'written', again, failure)
        if (failed(error, failure)) return
        call check_says(error, text, "orbit = 'state' ... attitude = 'given'")
        call check(error, all(abs([again%position - case%position, again%velocity - case%velocity, &
                                   again%angular_velocity - case%angular_velocity]) <= 0))
        call check(error, all(abs(again%quaternion - case%quaternion) <= 0))
    end subroutine test_written

    subroutine test_refusals(error)
        type(error_type), allocatable, intent(out) :: error

        call refused(NADIR//", orbit = 'kepler'", 'semi_major_axis_km ... missing')
        call refused(KEPLER//LF//NADIR//', position = 7e6, 0, 0', 'own.nml:5 ... "position" ... stands beside')
        call refused(KEPLER//LF//NADIR//', angular_velocity = 0, 0, 0', '"angular_velocity" ... stands beside')
        call refused("orbit = 'tle', tle_1 = '"//POLAR(1)//"', tle_2 = '"//POLAR(2)(:68)//"4'"//LF//NADIR, &
                     'own.nml ... the second of the two-line elements ... checksum')
        call refused("orbit = 'tle', tle_1 = '"//POLAR(2)//"', tle_2 = '"//POLAR(1)//"'"//LF//NADIR, &
                     'of the two-line elements: it has to begin with its number')
        call refused("orbit = 'tle', tle_1 = 'first', tle_2 = 'second'"//LF//NADIR, '69 characters')
        call refused(BY_LINES//LF//NADIR, 'time from them to the epoch = 11 days is outside', '2024-01-12')
        call refused("orbit = 'kepler', semi_major_axis_km = 7000, eccentricity = 0.5, inclination_deg = 89, node_deg = 0, "// &
                     "perigee_deg = 0, mean_anomaly_deg = 0"//LF//NADIR, &
                     'lies inside the Earth')
        call refused("orbit = 'kepler', semi_major_axis_km = 7000, eccentricity = 0.1, inclination_deg = 89, node_deg = 0, "// &
                     "perigee_deg = 0, mean_anomaly_deg = 180"//LF//NADIR, 'the perigee lies inside the Earth')
        call refused(KEPLER, 'quaternion ... missing')

    contains

        subroutine refused(truth, parts, day)
            character(*), intent(in) :: truth, parts
            character(*), intent(in), optional :: day
            type(case_t) :: case
            type(error_t), allocatable :: failure

            call state_case(truth, case, failure, day)
            call check_fails(error, failure, parts)
        end subroutine refused
    end subroutine test_refusals
end module test_stated_start
