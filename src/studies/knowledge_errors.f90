!> What each error in the operator's knowledge does to the estimated offset, alone: drawn many times, and to
!> first order by differences.
!>
!> The observations have no noise and stay the same; the knowledge that goes with them is drawn. So the
!> spread of the estimates is that by the knowledge alone, however small.
module gracecg_studies_knowledge_errors
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    use gracecg_base_text, only: rounded_text
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t, NOISE_GIVEN
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_estimators, only: estimate_offset
    use gracecg_simulation_operator_errors, only: operator_t, SOURCES, INERTIA, COMMON_ROD_GAIN, ACCELEROMETER_SCALE, &
        MAGNETOMETER_BIAS, TORQUE_CHANGE
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, observe_without_noise, tell_operator, operator_of_run
    use gracecg_planning_calibration, only: calibration_t
    implicit none
    private
    public :: knowledge_study_t, study_knowledge, study_all_knowledge, estimates_of_all, source_sigma, size_text
    public :: SIGMA_OF_CASE, SIGMA_A_PRIORI, SIGMA_BY_DEFAULT

    !> Where the size of an error comes from: the case's group operator, its a-priori sigmas, or the size
    !> that the table of the sources has for want of a better one
    integer, parameter :: SIGMA_OF_CASE = 1, SIGMA_A_PRIORI = 2, SIGMA_BY_DEFAULT = 3

    !> The error of the offset by one source.
    type :: knowledge_study_t
        integer :: source = 0           !! Its place in SOURCES
        real(dp), allocatable :: sigma(:)   !! Of its components, SI
        integer :: origin = SIGMA_BY_DEFAULT    !! Where that is from
        integer :: runs = 0             !! Of the Monte Carlo
        real(dp) :: rms(3) = 0          !! Estimate minus that with right knowledge, m
        real(dp) :: predicted(3) = 0    !! The same to first order, m
    end type knowledge_study_t

    !> Estimates with knowledge that is wrong, as pieces of work.
    type, extends(parallel_work_t) :: estimates_t
        type(simulator_t), pointer :: simulator => null()
        character(:), allocatable :: algorithm
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations         !! Without noise
        type(operator_t), allocatable :: operators(:)   !! One for each piece
        real(dp), allocatable :: offset(:, :)           !! (3, pieces), m
    contains
        procedure :: do_one => estimate_one
    end type estimates_t

contains

    !> Standard deviations of a source for a study, SI, and where they come from.
    pure subroutine source_sigma(operator, source, sigma, origin)
        type(operator_t), intent(in) :: operator        !! Of the case
        integer, intent(in) :: source                   !! Its place in SOURCES
        real(dp), allocatable, intent(out) :: sigma(:)  !! Of its components
        integer, intent(out) :: origin                  !! SIGMA_OF_CASE, SIGMA_A_PRIORI or SIGMA_BY_DEFAULT

        integer :: n

        n = SOURCES(source)%components
        origin = SIGMA_OF_CASE
        sigma = operator%sigma(:n, source)
        if (any(sigma > 0)) return
        origin = SIGMA_A_PRIORI
        associate (a_priori => operator%a_priori)
            select case (source)
            case (INERTIA)
                sigma = spread(a_priori%sigma_inertia, 1, n)
            case (COMMON_ROD_GAIN)
                sigma = [a_priori%sigma_rod_gain]
            case (ACCELEROMETER_SCALE)
                sigma = a_priori%aged_scale_sigmas()
            case (MAGNETOMETER_BIAS)
                sigma = a_priori%sigma_magnetometer_bias
            case (TORQUE_CHANGE)
                sigma = spread(a_priori%sigma_torque, 1, n)
            case default
                origin = SIGMA_BY_DEFAULT
                sigma = spread(SOURCES(source)%size*SOURCES(source)%factor, 1, n)
            end select
        end associate
    end subroutine source_sigma

    !> Draws one source in `runs` runs, with the standard deviations of source_sigma, and estimates from
    !> observations without noise. Fails as the estimator does.
    subroutine study_knowledge(simulator, algorithm, options, source, seed, runs, threads, study, error, progress)
        type(simulator_t), intent(in), target :: simulator
        character(*), intent(in) :: algorithm           !! One of ESTIMATOR_NAMES
        type(estimation_options_t), intent(in) :: options
        integer, intent(in) :: source                   !! Its place in SOURCES
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads      !! How many runs; in parallel
        type(knowledge_study_t), intent(out) :: study
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the estimates

        type(estimates_t) :: work
        type(operator_t) :: own, drawing
        integer :: i, n

        own = simulator%case%operator
        call source_sigma(own, source, study%sigma, study%origin)
        own%sigma = 0
        drawing = own
        n = size(study%sigma)
        drawing%sigma(:n, source) = study%sigma
        allocate (work%operators(1 + 2*n + runs), source=own)
        do i = 1, n
            work%operators(2*i)%value(i, source) = own%value(i, source) + study%sigma(i)
            work%operators(2*i + 1)%value(i, source) = own%value(i, source) - study%sigma(i)
        end do
        do i = 1, runs
            work%operators(1 + 2*n + i) = operator_of_run(simulator%case, drawing, seed, i)
        end do
        work%simulator => simulator
        work%algorithm = algorithm
        work%options = options
        work%options%covariance = .false.
        work%options%optimal%noise = NOISE_GIVEN        ! there is none to estimate
        call observe_without_noise(simulator, density_wave_t(), work%observations)
        allocate (work%offset(3, size(work%operators)))
        call run_parallel(work, size(work%operators), threads, error, progress)
        call add_context(error, 'error of '//trim(SOURCES(source)%name))
        if (allocated(error)) return
        study%source = source
        study%runs = runs
        associate (right => work%offset(:, 1), plus => work%offset(:, 2:2*n:2), minus => work%offset(:, 3:2*n + 1:2), &
                   drawn => work%offset(:, 2*n + 2:))
            study%predicted = sqrt(sum(((plus - minus)/2)**2, 2))
            study%rms = sqrt(sum((drawn - spread(right, 2, runs))**2, 2)/max(1, runs))
        end associate
    end subroutine study_knowledge

    !> All of SOURCES, one after the other.
    subroutine study_all_knowledge(calibration, algorithm, seed, runs, threads, studies, error, progress)
        type(calibration_t), intent(in) :: calibration
        character(*), intent(in) :: algorithm           !! One of ESTIMATOR_NAMES
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads      !! Runs of each source; in parallel
        type(knowledge_study_t), intent(out) :: studies(:)      !! In the order of SOURCES
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(simulator_t) :: simulator
        integer :: i

        call new_simulator(calibration%case, simulator, error)
        call expect_pieces(progress, estimates_of_all(runs), 'estimates')
        do i = 1, size(SOURCES)
            if (allocated(error)) return
            call tell(progress, 'knowledge, '//trim(SOURCES(i)%name))
            call study_knowledge(simulator, algorithm, calibration%options, i, seed, runs, threads, studies(i), error, &
                                 progress)
        end do
    end subroutine study_all_knowledge

    !> How many estimates study_knowledge makes for all of SOURCES together.
    pure integer function estimates_of_all(runs) result(estimates)
        integer, intent(in) :: runs     !! Of each source

        estimates = size(SOURCES)*(1 + runs) + 2*sum(SOURCES%components)
    end function estimates_of_all

    !> The size of a study's error, as a row or a comment has it: 'rod_gain: sigma 0.005 (default size)'.
    pure function size_text(study) result(text)
        type(knowledge_study_t), intent(in) :: study
        character(120) :: text      !! Blanks behind it

        character(*), parameter :: ORIGINS(3) = [character(12) :: 'of the case', 'a priori', 'default size']
        integer :: i

        text = trim(SOURCES(study%source)%name)//': sigma'
        do i = 1, size(study%sigma)
            text = trim(text)//' '//rounded_text(study%sigma(i)/SOURCES(study%source)%factor, 6)
            if (all(abs(study%sigma - study%sigma(1)) <= 0)) exit
        end do
        text = trim(text)//' '//trim(SOURCES(study%source)%unit)
        text = trim(text)//' ('//trim(ORIGINS(study%origin))//')'
    end function size_text

    subroutine estimate_one(self, i, error)
        class(estimates_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        type(solution_t) :: solution

        observations = self%observations
        call tell_operator(self%simulator, self%operators(i), observations)
        call estimate_offset(self%algorithm, observations, self%options, solution, error)
        self%offset(:, i) = solution%offset
    end subroutine estimate_one
end module gracecg_studies_knowledge_errors
