!> The theoretical limit of a case: the least covariance of the CG offset for its manoeuvre and the true
!> noise spectra, at its true state, and the consider covariance for what the operator knows only
!> within limits.
module gracecg_planning_bound
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_simulation_dynamics, only: OMEGA_PLACES => OMEGA, ATTITUDE_PLACES => ATTITUDE
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_parameters, only: PARAMETERS, PARAMETER_NAMES, OFFSET, RATE, SCALE_FACTORS, ROD_GAIN, &
        FIELD_BIAS, INERTIA, TORQUE_CHANGE, a_priori_sigmas
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, prepare_calibration, set_noise, &
        information_matrix, estimated_parameters
    use gracecg_planning_offset_bound, only: offset_bound_t, bound_offset
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_simulator, only: simulator_t, observe_without_noise
    use gracecg_simulation_switches, only: error_switches_t, new_switched_simulator
    implicit none
    private
    public :: case_bound_t, bound_of_case, SOURCES

    character(18), parameter :: SOURCES(5) = [character(18) :: 'scale factors', 'rod gain', &
                                              'magnetometer bias', 'inertia', 'unmodelled torque']
    !! What the consider covariance is made of

    !> The bound of a case.
    type, extends(offset_bound_t) :: case_bound_t
        real(dp) :: by_source(3, size(SOURCES)) = 0
        !! Standard deviation of d by each of SOURCES, m; 0 for what is estimated
    end type case_bound_t

contains

    !> The bound for what `optimal` would estimate under the options. The density wave counts only
    !> if the options give it.
    !>
    !> Fails when the case cannot be simulated, the rods are off, a noise level is not positive, or the
    !> offset is not determined.
    subroutine bound_of_case(case, options, bound, error)
        type(case_t), intent(in) :: case
        type(estimation_options_t), intent(in) :: options
        type(case_bound_t), intent(out) :: bound
        type(error_t), allocatable, intent(out) :: error

        type(simulator_t) :: simulator
        type(observation_set_t) :: observations

        call new_switched_simulator(case, error_switches_t(curved_force=.false., scale_factors=.false., &
                                                           magnetometer_bias=.false.), simulator, error)
        if (allocated(error)) return
        call observe_without_noise(simulator, density_wave_t(), observations)
        call bound_at_truth(simulator, observations, options, bound, error)
        call add_context(error, 'case '//trim(case%name))
    end subroutine bound_of_case

    subroutine bound_at_truth(simulator, observations, options, bound, error)
        type(simulator_t), intent(in) :: simulator
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(case_bound_t), intent(inout) :: bound
        type(error_t), allocatable, intent(out) :: error

        type(whitened_problem_t) :: problem
        type(fitting_data_t) :: data
        integer, allocatable :: estimated(:), considered(:), source(:)
        real(dp) :: sigma(PARAMETERS)
        real(dp), allocatable :: information(:, :), rhs(:), residuals(:)
        integer :: i

        call preprocess(observations, options, data, error)
        if (allocated(error)) return
        if (.not. any(abs(data%torque) > 0)) then
            call fail(error, 'the torque rods are off all the time: nothing turns the satellite so that '// &
                      'the offset could be seen; give a manoeuvre in groups &rod')
        else if (.not. all(observations%knowledge%star_camera_sigma > 0)) then
            call fail(error, 'the star camera has no noise: a bound needs the noise of all instruments; '// &
                      'give catalogue_noise or measurement_noise')
        end if
        if (allocated(error)) return
        estimated = estimated_parameters(options%optimal)
        call find_considered(estimated, considered, source)
        call prepare_calibration(observations%knowledge, options, data, [estimated, considered], problem)
        problem%state%quaternion = simulator%arc%state(ATTITUDE_PLACES, 0)
        problem%state%value(RATE) = simulator%arc%state(OMEGA_PLACES, 0)
        problem%state%value(OFFSET) = simulator%case%satellite%offset
        call set_noise(problem, error)
        if (allocated(error)) return
        call information_matrix(problem, information, rhs, residuals)
        sigma = a_priori_sigmas(observations%knowledge)
        call bound_offset(information, PARAMETER_NAMES(estimated), OFFSET, &
                          sigma(considered), bound%offset_bound_t, error)
        if (allocated(error)) return
        do i = 1, size(considered)
            associate (sum => bound%by_source(:, source(i)))
                sum = sqrt(sum**2 + bound%considered(:, i)**2)
            end associate
        end do
    end subroutine bound_at_truth

    !> The parameters that are not estimated, and the source that each belongs to.
    subroutine find_considered(estimated, considered, source)
        integer, intent(in) :: estimated(:)
        integer, allocatable, intent(out) :: considered(:), source(:)

        logical, allocatable :: left(:)
        integer :: i

        considered = [SCALE_FACTORS, ROD_GAIN, FIELD_BIAS, INERTIA, TORQUE_CHANGE]
        source = [spread(1, 1, 3), 2, spread(3, 1, 3), spread(4, 1, 6), spread(5, 1, 3)]
        left = [(.not. any(estimated == considered(i)), i=1, size(considered))]
        considered = pack(considered, left)
        source = pack(source, left)
    end subroutine find_considered
end module gracecg_planning_bound
