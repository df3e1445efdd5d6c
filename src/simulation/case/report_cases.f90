!> The six calibration cases of CSR-TM-00-01: sections 5.2 (case 1) and 6.1 (cases 2 and 3), each for
!> the front and the back satellite.
!>
!> Everything that the cases share is a default of `case_t` or of the instruments. What was fitted to the
!> report's figures stands below, with what it was fitted to. A second set, NAME-printed, takes the input
!> cards of section 5.2 as they are printed instead.
!>
!> Cases by name: these, or a user's own in a namelist file.
module gracecg_simulation_report_cases
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, EARTH_ROTATION_RATE
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_quaternion, only: normalised
    use gracecg_environment_time, only: utc_t, utc_plus
    use gracecg_spacecraft_torque_rods, only: new_harmonic_manoeuvre
    use gracecg_observations_knowledge, only: USUAL_DRAG
    use gracecg_simulation_case, only: case_t, read_case
    use gracecg_base_text, only: string_t, append, join, lower_case
    use gracecg_files_file, only: file_exists, directory_exists
    use gracecg_files_value, only: did_you_mean
    implicit none
    private
    public :: report_case, REPORT_CASE_NAMES, PRINTED_CASE_NAMES, published_name, SATELLITES, TIME_OF_CASE, &
        ROD_AMPLITUDE, ROD_FREQUENCY, find_case, is_built_in, expanded_cases, CASE_GROUPS

    !> Names of the two satellites, as cases begin with them
    character(5), parameter :: SATELLITES(2) = [character(5) :: 'front', 'back']
    !> Names of the six cases: satellite and number
    character(7), parameter :: REPORT_CASE_NAMES(6) = [character(7) :: 'front-1', 'front-2', 'front-3', &
                                                       'back-1', 'back-2', 'back-3']
    character(*), parameter :: AS_PRINTED = '-printed'      !! Ends the name of a case with the cards as printed
    !> The same six with the cards of section 5.2 as printed, and nothing fitted to the density and the wind
    character(15), parameter :: PRINTED_CASE_NAMES(6) = [character(15) :: &
        'front-1'//AS_PRINTED, 'front-2'//AS_PRINTED, 'front-3'//AS_PRINTED, &
        'back-1'//AS_PRINTED, 'back-2'//AS_PRINTED, 'back-3'//AS_PRINTED]

    type(utc_t), parameter :: EPOCH = utc_t(47528, 0.0_dp)
    !! 1989-01-02 00:00:00 UTC. Not stated in the report; inferred from its sidereal angle, which is the
    !! Greenwich mean sidereal time of that midnight
    real(dp), parameter :: SIDEREAL_ANGLE = 101.60748558_dp             !! Section 5.2, deg
    real(dp), parameter :: TIME_OF_CASE(3) = [0.0_dp, 1400.0_dp, 2658.0_dp]
    !! s after the epoch. Cases 2 and 3 lie later on the orbit of case 1

    real(dp), parameter :: INERTIA(3, 3) = reshape([70.23_dp, -3.0_dp, -2.883_dp, &
                                                    -3.0_dp, 345.14_dp, -0.348_dp, &
                                                    -2.883_dp, -0.348_dp, 388.84_dp], [3, 3])
    !! J_p, kg m^2, section 5.2
    real(dp), parameter :: MASS = 420.0_dp              !! kg, section 5.2
    real(dp), parameter :: DURATION = 60.0_dp           !! s
    real(dp), parameter :: ROD_AMPLITUDE = 30.0_dp      !! A m^2
    real(dp), parameter :: ROD_FREQUENCY = 0.1_dp       !! Hz

    ! Fitted to the axis windows of Figures 5.2 and 5.3 (docs/validation.md)
    real(dp), parameter :: DENSITY_SCALE = 0.8733_dp
    !! Of DTM-77 at the geodetic height, to the x component of the drag
    real(dp), parameter :: REFLECTIVITY_SUN = 0.56_dp
    !! eta of (2-8), to the solar radiation pressure; the card RADPR has 0.45
    real(dp), parameter :: WIND_EAST(2) = [46.0_dp, 36.8_dp]
    !! m/s, front and back, in case 1, to the y component of the drag; HWM93 gives 54 m/s there

    ! Fitted to the axis windows of Figures 5.6 and 5.7 (docs/validation.md), where six plates stand in
    ! for the report's tables of aerodynamic and solar torque
    real(dp), parameter :: CENTRE_OF_MASS_FRONT(3) = [19.4e-3_dp, -32.2e-3_dp, 55.6e-3_dp]
    real(dp), parameter :: CENTRE_OF_MASS_BACK(3) = [-11.8e-3_dp, 33.4e-3_dp, 75.1e-3_dp]
    !! From the middle of the trapezoidal prism, body axes, m. That x and y change sign with the
    !! direction of flight suggests that the report's tables are fixed to the flow, not to the body
    real(dp), parameter :: ACCOMMODATION = 0.938_dp     !! Of energy, walls at 300 K
    real(dp), parameter :: SPECULAR = 0.238_dp          !! Reflectivity of all plates

    !> Initial values and rods of a case: position (m) and velocity (m/s), inertial; attitude, inertial to body, scalar
    !> last; angular velocity about body y (rad/s); signs of the rods' moments. In the order of REPORT_CASE_NAMES
    type :: start_t
        real(dp) :: position(3), velocity(3), quaternion(4), rate
        integer :: pattern(3)
    end type start_t
    type(start_t), parameter :: STARTS(6) = [ &
        start_t([6837865.32398033_dp, 0.0_dp, 0.0_dp], [0.0_dp, -0.066613973791_dp, 7638.807717665099_dp], &
                [-0.7008547308853075_dp, -3.115068773005844e-6_dp, 0.7133040348803767_dp, 3.059634305881649e-6_dp], &
                1.114901594e-3_dp, [0, 1, 1]), &
        start_t([53166.9012866642_dp, 50.3762086975_dp, 6838048.9781353170_dp], &
                [-7627.3588408146_dp, -0.0096034177_dp, 63.3233882824_dp], &
                [-0.9999051930_dp, -0.0000000609_dp, 0.0137697130_dp, 0.0000043659_dp], 0.111490159e-2_dp, [0, 1, -1]), &
        start_t([-6739303.8283807930_dp, 48.9237966735_dp, 1198310.5772177500_dp], &
                [-1337.7622725168_dp, 0.1452268716_dp, -7512.2443788538_dp], &
                [-0.7728330709_dp, 0.0000027703_dp, -0.6346093637_dp, 0.0000033749_dp], 0.111490159e-2_dp, [0, 1, 1]), &
        start_t([6833646.00660327_dp, 2.09260535_dp, -239624.73079019_dp], &      ! a second "front" in section 5.2
                [267.425734562641_dp, -0.066573212320_dp, 7634.133605517418_dp], &
                [3.114586367226337e-6_dp, -0.7008547308853075_dp, -3.060227453483457e-6_dp, 0.7133040348803732_dp], &
                -1.114907355e-3_dp, [0, -1, 1]), &
        start_t([291680.8661387600_dp, -48.5674705798_dp, 6831570.5338286750_dp], &
                [-7621.0475706862_dp, -0.0144524709_dp, 329.1764019231_dp], &
                [0.0000000601_dp, -0.9999052485_dp, -0.0000043660_dp, 0.0137656809_dp], -0.111490736e-2_dp, [0, 1, 1]), &
        start_t([-6693453.2487186490_dp, 45.0419246185_dp, 1431899.2109399360_dp], &
                [-1598.8879354469_dp, 0.1417855019_dp, -7461.0147865065_dp], &
                [-0.0000027710_dp, -0.7728282124_dp, -0.0000033745_dp, -0.6346152804_dp], -0.111490736e-2_dp, [0, -1, 1])]

    !> Names for several built-in cases: the report's of one satellite, all six of them, and the six with the input
    !> cards as printed
    character(7), parameter :: CASE_GROUPS(4) = [character(7) :: 'front', 'back', 'all', 'printed']

contains

    !> One of the report's cases. Fails for a name that is none of REPORT_CASE_NAMES and PRINTED_CASE_NAMES.
    subroutine report_case(name, case, error)
        character(*), intent(in) :: name    !! One of REPORT_CASE_NAMES or PRINTED_CASE_NAMES
        type(case_t), intent(out) :: case
        type(error_t), allocatable, intent(out) :: error

        type(start_t) :: start

        if (.not. any(REPORT_CASE_NAMES == published_name(name))) then
            call fail(error, 'there is no built-in case "'//trim(name)//'"')
            return
        end if
        case%name = published_name(name)
        case%pattern_rule = 'y-z'
        case%satellite%name = name(:index(name, '-') - 1)
        read (case%name(index(name, '-') + 1:), *) case%number

        case%epoch = utc_plus(EPOCH, TIME_OF_CASE(case%number))
        case%duration = DURATION
        case%operator%a_priori%signs_known = .true.     ! the report doubts no axis and no sign
        case%operator%a_priori%drag = USUAL_DRAG        ! 3.4e-7 to 6.2e-7, all six as one
        case%earth_rotation = 'given'
        case%sidereal_angle = (SIDEREAL_ANGLE + EARTH_ROTATION_RATE/DEGREE*TIME_OF_CASE(case%number))*DEGREE
        case%satellite%mass = MASS
        case%satellite%inertia = INERTIA
        case%density_scale = DENSITY_SCALE
        case%satellite%reflectivity_sun = REFLECTIVITY_SUN
        case%satellite%wall%accommodation = ACCOMMODATION
        case%satellite%specular = SPECULAR
        case%earth_radiation_constants = 'constant-emissivity'
        case%earth_radiation_rings = 2
        case%earth_radiation_centres = 'mid-angle'
        if (case%satellite%name == 'front') then
            case%satellite%offset = [0.3e-3_dp, 0.4e-3_dp, -0.5e-3_dp]               ! section 6.2
            case%wind_east = WIND_EAST(1)
            case%satellite%centre_of_mass = CENTRE_OF_MASS_FRONT
        else
            case%satellite%offset = [0.4e-3_dp, -0.4e-3_dp, 0.4e-3_dp]
            case%wind_east = WIND_EAST(2)
            case%satellite%centre_of_mass = CENTRE_OF_MASS_BACK
        end if
        start = STARTS(findloc(REPORT_CASE_NAMES, published_name(name), 1))
        case%position = start%position
        case%velocity = start%velocity
        case%quaternion = normalised(start%quaternion)
        case%angular_velocity = [0.0_dp, start%rate, 0.0_dp]
        case%wind_model = merge('constant', 'hwm93   ', case%number == 1)
        if (case%name /= name) call print_cards(name, case)
        call new_harmonic_manoeuvre(start%pattern, ROD_AMPLITUDE, ROD_FREQUENCY, 0.0_dp, DURATION, case%satellite%rods, error)
    end subroutine report_case

    !> The name under which a case is published: that of a case with the cards as printed without its end.
    elemental function published_name(name) result(published)
        character(*), intent(in) :: name    !! 'front-1', 'front-1-printed', or any other
        character(len(name)) :: published

        published = name
        if (any(PRINTED_CASE_NAMES == name)) published = name(:len_trim(name) - len(AS_PRINTED))
    end function published_name

    !> Puts the cards of section 5.2 as printed (RADPR 0.45, EM 0 to 2 and the yearly EM 1), DTM-77's own
    !> density and the table of winds in the place of what was fitted to the figures. Rings of the Earth's
    !> surface, plates and centre of mass stay: no card has them in the form that is used here.
    pure subroutine print_cards(name, case)
        character(*), intent(in) :: name        !! Of the case
        type(case_t), intent(inout) :: case

        type(case_t) :: default

        case%name = name
        case%density_scale = default%density_scale
        case%satellite%reflectivity_sun = default%satellite%reflectivity_sun
        case%earth_radiation_constants = default%earth_radiation_constants
        case%wind_model = 'hwm93'
        case%wind_east = default%wind_east
    end subroutine print_cards

    !> The case of a name: a built-in one, else the one in the namelist file of that path. Fails
    !> when it is neither, and where `read_case` fails.
    subroutine find_case(name_or_path, case, error)
        character(*), intent(in) :: name_or_path    !! 'front-1' ... 'back-3-printed', or a path
        type(case_t), intent(out) :: case
        type(error_t), allocatable, intent(out) :: error

        if (is_built_in(name_or_path)) then
            call report_case(lower_case(name_or_path), case, error)
        else if (name_or_path == '') then
            call fail(error, 'the name of the case is empty')
        else if (file_exists(name_or_path)) then
            call read_case(name_or_path, case, error)
        else if (directory_exists(name_or_path)) then
            call fail(error, trim(name_or_path)//': is a folder, not a case file')
        else
            call fail(error, 'no case "'//trim(name_or_path)// &
                      '": it is neither a built-in case ('//join(REPORT_CASE_NAMES, ', ')// &
                      ', or one of these with -printed behind it) nor a namelist file'// &
                      did_you_mean(name_or_path, [character(15) :: REPORT_CASE_NAMES, PRINTED_CASE_NAMES]))
        end if
    end subroutine find_case

    !> Is it the name of a built-in case?
    logical function is_built_in(name)
        character(*), intent(in) :: name    !! In whatever case

        is_built_in = any(REPORT_CASE_NAMES == lower_case(name)) .or. any(PRINTED_CASE_NAMES == lower_case(name))
    end function is_built_in

    !> A list of cases in which each of CASE_GROUPS, unless it is a file, has given way to the names it stands for.
    subroutine expanded_cases(names, expanded)
        type(string_t), intent(in) :: names(:)                  !! Names and paths
        type(string_t), allocatable, intent(out) :: expanded(:) !! At least as many

        integer :: i

        allocate (expanded(0))
        do i = 1, size(names)
            if (any(CASE_GROUPS == lower_case(names(i)%text)) .and. .not. file_exists(names(i)%text)) then
                call append_group(lower_case(names(i)%text), expanded)
            else
                call append(expanded, names(i)%text)
            end if
        end do
    end subroutine expanded_cases

    subroutine append_group(group, names)
        character(*), intent(in) :: group       !! One of CASE_GROUPS
        type(string_t), allocatable, intent(inout) :: names(:)

        integer :: i

        do i = 1, size(REPORT_CASE_NAMES)
            if (group == 'printed') then
                call append(names, trim(PRINTED_CASE_NAMES(i)))
            else if (group == 'all' .or. index(REPORT_CASE_NAMES(i), group//'-') == 1) then
                call append(names, trim(REPORT_CASE_NAMES(i)))
            end if
        end do
    end subroutine append_group
end module gracecg_simulation_report_cases
