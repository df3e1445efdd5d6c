!> The consider covariance of the bound against a Monte Carlo: each error of the operator's knowledge is
!> drawn alone, and `optimal` estimates with it from observations without noise.
!>
!> Bound and draws mean the same by a standard deviation: that of the elements of the inertia tensor in units
!> of the smallest moment, of one gain of all rods, of the factors of the accelerometer's axes, of the
!> magnetometer's bias and of the change of the torque; of the other sources that of the group operator.
module gracecg_studies_consider_check
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_progress, only: progress_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_simulator, only: simulator_t
    use gracecg_simulation_switches, only: error_switches_t, new_switched_simulator
    use gracecg_planning_bound, only: case_bound_t, bound_of_case, OPERATOR_PLACES
    use gracecg_studies_knowledge_errors, only: knowledge_study_t, study_knowledge, source_sigma
    implicit none
    private
    public :: consider_check_t, check_consider

    !> One source of a case.
    type, extends(knowledge_study_t) :: consider_check_t
        real(dp) :: considered(3) = 0   !! Standard deviation of d by the bound, m
        real(dp) :: noise(3) = 0        !! The bound itself, m, to judge the size by
    end type consider_check_t

contains

    !> Checks one source of a case, with its standard deviations as source_sigma gives them. Fails as
    !> bound_of_case and the estimator do. A source that `optimal` estimates under the case's options adds
    !> nothing in the bound.
    subroutine check_consider(case, options, source, seed, runs, threads, check, error, progress)
        type(case_t), intent(in) :: case
        type(estimation_options_t), intent(in) :: options
        integer, intent(in) :: source               !! Its place in SOURCES
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads  !! How many runs; in parallel
        type(consider_check_t), intent(out) :: check
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the estimates

        type(case_t) :: alone
        type(case_bound_t) :: bound
        type(estimation_options_t) :: own
        type(simulator_t) :: simulator
        real(dp), allocatable :: sigma(:)
        integer :: origin, place

        own = options
        own%optimal%estimate_within_limits = .false.    ! but considered
        alone = case
        call source_sigma(case%operator, source, sigma, origin)
        alone%operator%sigma = 0
        alone%operator%sigma(:size(sigma), source) = sigma
        call bound_of_case(alone, options, bound, error)
        if (.not. allocated(error)) &
            call new_switched_simulator(alone, error_switches_t(curved_force=.false., scale_factors=.false., &
                                                                magnetometer_bias=.false.), simulator, error)
        if (.not. allocated(error)) &
            call study_knowledge(simulator, 'optimal', own, source, seed, runs, threads, &
                                 check%knowledge_study_t, error, progress)
        call add_context(error, 'case '//trim(case%name))
        if (allocated(error)) return
        check%origin = origin
        check%noise = bound%sigma
        place = findloc(OPERATOR_PLACES, source, 1)
        if (place > 0) then
            check%considered = bound%by_source(:, place)
        else
            check%considered = bound%by_knowledge(:, source)
        end if
    end subroutine check_consider
end module gracecg_studies_consider_check
