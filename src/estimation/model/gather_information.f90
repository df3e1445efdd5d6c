!> The information of a run out of its fit.
module gracecg_estimation_gather_information
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_information, only: information_t, eliminated_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_observations_parameters, only: parameter_names
    use gracecg_estimation_parameters, only: a_priori_sigmas
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, set_noise, with_parameters, information_matrix
    use gracecg_estimation_run_information, only: run_information_t, JOINED, JOINED_COUNT, beliefs_of
    implicit none
    private
    public :: gather_information, move_joined

    integer, parameter :: STEPS = 3     !! Of the parameters of the run alone, to their new best values, at most
    real(dp), parameter :: SETTLED = 1e-3_dp    !! A step that is not taken any more, in standard deviations: what is joined is as
    !! if it were

contains

    !> The information of a problem at its state. Fails when the samples do not determine the parameters of the
    !> run alone.
    subroutine gather_information(knowledge, options, problem, information, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(whitened_problem_t), intent(in) :: problem
        type(run_information_t), intent(out) :: information
        type(error_t), allocatable, intent(out) :: error

        type(whitened_problem_t) :: wider
        real(dp), allocatable :: own_step(:)

        call widen(knowledge, options, problem, wider, error)
        if (.not. allocated(error)) call reduce(knowledge, problem, wider, information, own_step, error)
    end subroutine gather_information

    !> Moves a problem to other values of what is joined, and all else to what then fits best: the point at which
    !> several runs agree. All else first follows as the information gathered before says. Fails as gather_information does.
    subroutine move_joined(knowledge, options, values, problem, information, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        real(dp), intent(in) :: values(JOINED_COUNT)    !! Of JOINED, SI units
        type(whitened_problem_t), intent(inout) :: problem
        type(run_information_t), intent(inout) :: information   !! At the problem's state; at that where it is moved to
        type(error_t), allocatable, intent(out) :: error

        type(whitened_problem_t) :: wider
        real(dp), allocatable :: own_step(:), correction(:)
        real(dp) :: in_sigmas
        integer :: i

        call widen(knowledge, options, problem, wider, error)
        if (allocated(error)) return
        if (allocated(information%own_by_joined)) then
            associate (change => values - wider%state%value(JOINED))
                correction = [spread(0.0_dp, 1, JOINED_COUNT), matmul(information%own_by_joined, change)]
            end associate
            call wider%correct(correction)
        end if
        wider%state%value(JOINED) = values
        do i = 0, STEPS
            call reduce(knowledge, problem, wider, information, own_step, error, in_sigmas)
            if (allocated(error) .or. i == STEPS) exit
            if (in_sigmas <= SETTLED) exit
            correction = [spread(0.0_dp, 1, JOINED_COUNT), own_step]
            call wider%correct(correction)
        end do
        problem%state = wider%state
    end subroutine move_joined

    !> The same problem with all of JOINED among its parameters, in front, without a-priori knowledge of them.
    subroutine widen(knowledge, options, problem, wider, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(whitened_problem_t), intent(in) :: problem
        type(whitened_problem_t), intent(out) :: wider
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        associate (estimated => problem%model%estimated)
            call with_parameters(knowledge, options, problem, &
                                 [JOINED, pack(estimated, [(.not. any(JOINED == estimated(i)), i=1, size(estimated))])], wider)
        end associate
        call wider%forget_prior(JOINED_COUNT)
        call set_noise(wider, error)
    end subroutine widen

    !> The normal equations of the samples, reduced by the parameters of the run alone.
    subroutine reduce(knowledge, problem, wider, information, own_step, error, in_sigmas)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(whitened_problem_t), intent(in) :: problem         !! As the run estimates it
        type(whitened_problem_t), intent(inout) :: wider
        type(run_information_t), intent(out) :: information
        real(dp), allocatable, intent(out) :: own_step(:)       !! To the best values of the run's own, the others kept
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(out), optional :: in_sigmas        !! The largest part of the step, in its standard deviation

        type(information_t) :: samples
        type(eliminated_t) :: own
        real(dp), allocatable :: residuals(:), sigma(:)
        integer :: n, i, priors

        n = size(wider%model%estimated)
        priors = wider%observations - wider%sample_rows()
        call information_matrix(wider, samples%matrix, samples%rhs, residuals)
        samples%squares = sum(residuals**2)
        call samples%eliminate(JOINED_COUNT, own, error, parameter_names(wider%model%estimated(JOINED_COUNT + 1:)))
        call add_context(error, 'information of the run')
        if (allocated(error)) return
        own_step = own%value
        if (present(in_sigmas)) in_sigmas = maxval([(abs(own_step(i))/sqrt(own%inverse(i, i)), i=1, size(own_step))])
        information%information_t = samples
        information%own_by_joined = -transpose(own%gain)
        information%name = knowledge%name
        information%epoch = knowledge%epoch
        information%point = wider%state%value(JOINED)
        information%redundancy = 3*count(wider%star_kept) + count(wider%acceleration_kept) + priors - (n - JOINED_COUNT)
        information%estimated = [(any(problem%model%estimated == JOINED(i)), i=1, JOINED_COUNT)]
        sigma = a_priori_sigmas(knowledge)
        information%prior_sigma = sigma(JOINED)
        information%belief = beliefs_of(knowledge)
    end subroutine reduce
end module gracecg_estimation_gather_information
