!> A calibration: a case, which is simulated, and how it is estimated. One file has both, each in groups of its
!> own: the simulation reads the case, the estimators read their options.
!>
!> The case of an observation set is as its operator would plan it again: bound, timing and design of a real manoeuvre, by the
!> same commands as those of a case.
module gracecg_planning_calibration
    use gracecg_base_error, only: error_t, add_context, fail
    use gracecg_files_file, only: output_file_t, file_exists
    use gracecg_observations_observation_files, only: read_observations, OBSERVATION_FILES, SETUP_FILE
    use gracecg_observations_observation_set, only: observation_set_t, check_observations, has_orbit, has_star_camera
    use gracecg_simulation_case, only: case_t, case_from_text, case_text
    use gracecg_simulation_report_cases, only: published_name, find_case, is_built_in
    use gracecg_estimation_options, only: estimation_options_t, read_options, options_from_text, options_text
    use gracecg_estimation_estimators, only: estimate_offset
    use gracecg_estimation_report_options, only: report_options
    use gracecg_estimation_solution, only: solution_t
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_base_text, only: string_t
    use gracecg_base_vectors, only: cross
    use gracecg_observations_knowledge, only: NO_FIELD_MODEL
    use gracecg_estimation_first_guess, only: guess_rotation
    use gracecg_estimation_star_attitude, only: star_attitude_t, take_star_attitude
    implicit none
    private
    public :: calibration_t, find_calibration, calibration_from_text, calibration_text, write_calibration, &
        case_of_observations

    !> A case and how it is estimated.
    type :: calibration_t
        type(case_t) :: case                        !! What is simulated
        type(estimation_options_t) :: options       !! How it is estimated
    end type calibration_t

    real(dp), parameter :: LONGEST_CHORD = 20       !! Of the orbit, of which the velocity is found, s

contains

    !> The calibration of a name: a built-in case with the report's options, else the namelist file of that path, or the
    !> folder of an observation set. Fails when it is none, and as `read_case`, `read_options` and `case_of_observations` do.
    subroutine find_calibration(name_or_path, calibration, error)
        character(*), intent(in) :: name_or_path    !! 'front-1' ... 'back-3-printed', or a path
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        character(:), allocatable :: setup

        setup = name_or_path//'/'//trim(OBSERVATION_FILES(SETUP_FILE))
        if (file_exists(setup)) then
            call read_observations(name_or_path, observations, error)
            if (.not. allocated(error)) call case_of_observations(observations, calibration%case, error)
            if (.not. allocated(error)) call read_options(setup, calibration%options, error, beside=.true.)
            if (.not. allocated(error)) call take_offset()
            call add_context(error, name_or_path)
            return
        end if
        call find_case(name_or_path, calibration%case, error)
        if (allocated(error)) return
        if (is_built_in(name_or_path)) then
            calibration%options = report_options(trim(published_name(calibration%case%name)))
        else
            call read_options(name_or_path, calibration%options, error, beside=.true.)
        end if

    contains

        !> The offset that `optimal` finds, since some errors grow with it; else 0. A run that is too long for one fit has none.
        subroutine take_offset()
            type(estimation_options_t) :: quick
            type(solution_t) :: solution
            type(error_t), allocatable :: failure

            quick = calibration%options
            quick%test_beliefs = .false.
            call estimate_offset('optimal', observations, quick, solution, failure)
            if (allocated(failure)) return
            if (solution%converged) calibration%case%satellite%offset = solution%offset
        end subroutine take_offset
    end subroutine find_calibration

    !> The calibration of the text of a case file; `name` stands for the file in messages.
    subroutine calibration_from_text(text, name, calibration, error)
        character(*), intent(in) :: text, name      !! Content; what stands for the file in messages
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error

        call case_from_text(text, name, calibration%case, error)
        if (.not. allocated(error)) &
            call options_from_text(text, name, calibration%options, error, beside=.true.)
    end subroutine calibration_from_text

    !> The text of a case file with both: what `find_calibration` reads. Fails when a number is not finite.
    subroutine calibration_text(calibration, text, error)
        type(calibration_t), intent(in) :: calibration
        character(:), allocatable, intent(out) :: text  !! Lines separated by line feeds
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: options

        call case_text(calibration%case, text, error)
        if (.not. allocated(error)) call options_text(calibration%options, options, error)
        if (.not. allocated(error)) text = text//new_line('a')//new_line('a')//options
    end subroutine calibration_text

    !> The same as a file that every command takes for a case. Fails as calibration_text, and when it cannot be written.
    subroutine write_calibration(path, calibration, error)
        character(*), intent(in) :: path                !! An existing file is replaced
        type(calibration_t), intent(in) :: calibration
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: text

        call calibration_text(calibration, text, error)
        if (.not. allocated(error)) call file%open(path, error)
        if (allocated(error)) return
        call file%about('!')
        call file%line(text)
        call file%commit(error)
    end subroutine write_calibration

    !> The case of an observation set: its satellite, manoeuvre and instruments as the operator knows them, on the orbit and in
    !> the attitude that its samples show, turning as a satellite that points to the Earth. Air and wind are left out:
    !> nothing of them is observed. The offset is 0. Fails without an orbit or a star camera.
    subroutine case_of_observations(observations, case, error)
        type(observation_set_t), intent(in) :: observations
        type(case_t), intent(out) :: case
        type(error_t), allocatable, intent(out) :: error

        call check_observations(observations, error)
        if (allocated(error)) return
        if (.not. has_orbit(observations)) then
            call fail(error, 'the observations have no orbit (orbit.csv): without it nothing can be planned')
        else if (.not. has_star_camera(observations)) then
            call fail(error, 'the observations have no star camera: without the attitude nothing can be planned')
        end if
        if (allocated(error)) return
        associate (knowledge => observations%knowledge, satellite => case%satellite)
            case%name = knowledge%name
            case%epoch = knowledge%epoch
            case%duration = knowledge%duration
            case%limits = knowledge%limits
            case%operator%a_priori = knowledge%a_priori
            case%operator%head = max(1, knowledge%camera)
            satellite%mass = knowledge%mass
            satellite%inertia = knowledge%inertia
            satellite%rods = knowledge%rods
            satellite%line = knowledge%line
            satellite%accelerometer%noise = knowledge%accelerometer_noise
            satellite%accelerometer%noise%level = knowledge%line%number*knowledge%accelerometer_noise%level
            satellite%accelerometer%sampling_interval = knowledge%accelerometer_interval
            satellite%star_camera%sampling_interval = knowledge%star_camera_interval
            satellite%magnetometer%sampling_interval = knowledge%magnetometer_interval
            case%interval = knowledge%accelerometer_interval
            if (knowledge%earth_orientation == 'report' .and. abs(knowledge%sidereal_angle) > 0) case%earth_rotation = 'given'
            case%sidereal_angle = knowledge%sidereal_angle
            case%earth_orientation = knowledge%earth_orientation
            case%earth_parameters = knowledge%earth_parameters
            case%ut1_minus_utc = max(-1.0_dp, min(1.0_dp, knowledge%earth_parameters%ut1_minus_utc))
            if (knowledge%field_model /= NO_FIELD_MODEL) case%field_model = knowledge%field_model
        end associate
        case%density_model = 'none'
        case%density_wave_random = .false.
        case%density_wave%amplitude = 0
        case%wind_model = 'none'
        call find_orbit(observations, case)
        call find_attitude(observations, case)
    end subroutine case_of_observations

    !> Position and velocity at the epoch, of two positions, by the first terms of f and g of Kepler's motion.
    subroutine find_orbit(observations, case)
        type(observation_set_t), intent(in) :: observations
        type(case_t), intent(inout) :: case

        real(dp) :: pull, step
        integer :: first, second

        associate (time => observations%orbit_time, position => observations%orbit_position)
            first = max(1, min(last_not_after(time, 0.0_dp), size(time) - 1))
            second = max(first + 1, last_not_after(time, time(first) + LONGEST_CHORD))
            pull = EARTH_GM/norm2(position(:, first))**3
            step = time(second) - time(first)
            case%velocity = (position(:, second) - (1 - pull*step**2/2 + (pull*step**2)**2/24)*position(:, first))/ &
                            (step - pull*step**3/6)
            step = -time(first)
            case%position = (1 - pull*step**2/2)*position(:, first) + step*case%velocity
            case%velocity = case%velocity - pull*step*position(:, first)
        end associate
    end subroutine find_orbit

    !> Attitude at the epoch as the star camera saw it, and the angular velocity with which it follows the orbit.
    subroutine find_attitude(observations, case)
        type(observation_set_t), intent(in) :: observations
        type(case_t), intent(inout) :: case

        type(star_attitude_t) :: stars
        type(string_t), allocatable :: warnings(:)
        real(dp) :: turning(3)

        allocate (warnings(0))
        call take_star_attitude(observations, [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], stars, warnings)
        call guess_rotation(stars%time, stars%quaternion, case%quaternion, turning)
        case%angular_velocity = matmul(rotation_matrix(case%quaternion), cross(case%position, case%velocity))/ &
                                sum(case%position**2)
    end subroutine find_attitude
end module gracecg_planning_calibration
