!> The case that an observation set is of, as its operator would plan it again: bound, timing and design of a real manoeuvre,
!> by the same commands as those of a case.
module gracecg_planning_observed_case
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_base_text, only: string_t
    use gracecg_base_vectors, only: cross
    use gracecg_observations_knowledge, only: NO_FIELD_MODEL
    use gracecg_observations_observation_set, only: observation_set_t, check_observations, has_orbit, has_star_camera
    use gracecg_simulation_case, only: case_t
    use gracecg_estimation_first_guess, only: guess_rotation
    use gracecg_estimation_star_attitude, only: star_attitude_t, take_star_attitude
    implicit none
    private
    public :: case_of_observations

    real(dp), parameter :: LONGEST_CHORD = 20       !! Of the orbit, of which the velocity is found, s

contains

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
            satellite%accelerometer%noise = knowledge%accelerometer_noise
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
end module gracecg_planning_observed_case
