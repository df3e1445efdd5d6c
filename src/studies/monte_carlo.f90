!> Many calibrations of one case: errors of the estimated offset, and what theory predicts for them.
module gracecg_studies_monte_carlo
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: PI, MILLIMETRE
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_text, only: integer_text, string_t, append
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_base_progress, only: progress_t
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t, NOISE_GIVEN
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_estimators, only: estimate_offset
    use gracecg_simulation_simulator, only: simulator_t, observe, observe_without_noise
    implicit none
    private
    public :: monte_carlo_t, some_runs, run_monte_carlo, alteration_t, run_recorder_t, error_statistics_t, statistics_of, &
        rms_of_errors
    public :: prediction_t, predict_errors, error_study_t, study_errors

    !> The estimates of runs of one case and algorithm.
    type :: monte_carlo_t
        integer, allocatable :: run(:)              !! Numbers of the runs
        real(dp), allocatable :: offset(:, :)       !! (3, runs), m; a campaign's are in mm
        logical, allocatable :: converged(:)        !! (runs)
        real(dp), allocatable :: normalised(:)
        !! Error squared in units of the estimate's own covariance: a chi-square with 3 degrees of freedom
        !! if that is honest. (runs); 0 where the algorithm gives no covariance with the estimate
        type(string_t), allocatable :: refused(:)
        !! Of runs without an estimate, which are none of the others: the number, and why
    contains
        procedure :: keep       !! Leaves some of the runs, in a given order
        procedure :: add        !! Takes others in, in the order of their numbers
    end type monte_carlo_t

    !> Statistics of the errors of the offset, mm.
    type :: error_statistics_t
        real(dp) :: rms(3) = 0          !! About the true offset
        real(dp) :: mean(3) = 0         !! Of estimate minus truth
        real(dp) :: deviation(3) = 0    !! About the mean, of the sample
    end type error_statistics_t

    !> What a covariance analysis predicts for the errors, m.
    type :: prediction_t
        real(dp) :: rms(3)          !! sqrt(noise^2 + bias^2 + wave^2)
        real(dp) :: noise(3)        !! Standard deviation by the noise of accelerometer and star camera
        real(dp) :: bias(3)         !! By scale factors, biases and unmodelled dynamics
        real(dp) :: wave(3)         !! RMS by the density wave of random phase
    end type prediction_t

    !> Errors of the offset in runs, beside what theory expects.
    type :: error_study_t
        integer :: runs = 0             !! Of the Monte Carlo; 0: theory alone
        real(dp) :: rms(3) = 0          !! Of these runs, m
        real(dp) :: predicted(3) = 0    !! RMS by theory, m; 0: not of errors
    end type error_study_t

    !> A change of every observation set before it is estimated.
    type, abstract :: alteration_t
    contains
        procedure(alter_interface), deferred :: alter
        !! Changes the observations of a run before they are estimated from
    end type alteration_t

    abstract interface
        !> Changes the observations of a run; called from several threads at once.
        subroutine alter_interface(self, simulator, seed, run, observations)
            import :: i8, alteration_t, simulator_t, observation_set_t
            class(alteration_t), intent(in) :: self
            type(simulator_t), intent(in) :: simulator
            integer(i8), intent(in) :: seed        !! Of the random numbers
            integer, intent(in) :: run
            type(observation_set_t), intent(inout) :: observations
        end subroutine alter_interface
    end interface

    !> Who wants every run as soon as it is done.
    type, abstract :: run_recorder_t
    contains
        procedure(record_interface), deferred :: record
        !! Takes the estimate of one run
    end type run_recorder_t

    abstract interface
        !> Takes the estimate of one run; called by one thread at a time, in whatever order the runs end. Fails
        !> when it cannot be kept; the Monte Carlo fails then.
        subroutine record_interface(self, run, offset, converged, normalised, error)
            import :: dp, error_t, run_recorder_t
            class(run_recorder_t), intent(inout) :: self
            integer, intent(in) :: run              !! Its number
            real(dp), intent(in) :: offset(3)       !! Estimate of d, m
            logical, intent(in) :: converged        !! Did it converge?
            real(dp), intent(in) :: normalised      !! As in monte_carlo_t
            type(error_t), allocatable, intent(out) :: error
        end subroutine record_interface
    end interface

    !> The runs of a Monte Carlo as pieces of work.
    type, extends(parallel_work_t) :: runs_t
        type(simulator_t), pointer :: simulator => null()
        class(alteration_t), pointer :: alteration => null()    !! Not associated: none
        class(run_recorder_t), pointer :: recorder => null()    !! Likewise
        character(:), allocatable :: algorithm
        type(estimation_options_t) :: options
        integer(i8) :: seed = 1
        type(monte_carlo_t) :: results
        logical, allocatable :: done(:)
        logical :: leaves_out = .false.         !! Runs whose estimate fails
        type(string_t), allocatable :: refusal(:)   !! (runs), then
    contains
        procedure :: do_one => do_run
    end type runs_t

contains

    !> Simulates and estimates the given runs, on `threads` threads. A run's numbers depend on nothing
    !> but seed, case and its own number.
    !>
    !> Fails when a run fails: the error is that of the failed run with the lowest number; and when the listener
    !> wants to stop. The results are those of the runs that were done. With `leave_out` it fails only when all fail.
    subroutine run_monte_carlo(simulator, algorithm, options, seed, runs, threads, results, error, alteration, &
                               progress, recorder, leave_out)
        type(simulator_t), intent(in), target :: simulator
        character(*), intent(in) :: algorithm   !! One of ESTIMATOR_NAMES
        type(estimation_options_t), intent(in) :: options   !! The estimates are not judged, whatever they say
        integer(i8), intent(in) :: seed             !! Of the random numbers
        integer, intent(in) :: runs(:)          !! Numbers of the runs, increasing
        integer, intent(in) :: threads          !! How many to use
        type(monte_carlo_t), intent(out) :: results
        type(error_t), allocatable, intent(out) :: error
        class(alteration_t), intent(in), optional, target :: alteration     !! Of every observation set
        class(progress_t), intent(inout), optional :: progress      !! Counts the runs
        class(run_recorder_t), intent(inout), optional, target :: recorder  !! Gets every run
        logical, intent(in), optional :: leave_out  !! Runs whose estimate fails

        type(runs_t) :: work
        integer :: i

        work%simulator => simulator
        if (present(alteration)) work%alteration => alteration
        if (present(recorder)) work%recorder => recorder
        work%algorithm = algorithm
        work%options = options
        work%options%covariance = .false.
        work%seed = seed
        work%results = some_runs(runs)
        allocate (work%done(size(runs)), source=.false.)
        allocate (work%refusal(size(runs)))
        if (present(leave_out)) work%leaves_out = leave_out
        call run_parallel(work, size(runs), threads, error, progress)
        results = work%results
        do i = 1, size(runs)
            if (allocated(work%refusal(i)%text)) call append(results%refused, work%refusal(i)%text)
        end do
        if (size(results%refused) == size(runs) .and. size(runs) > 0 .and. .not. allocated(error)) &
            call fail(error, results%refused(1)%text)
        call results%keep(pack([(i, i=1, size(runs))], work%done))
    end subroutine run_monte_carlo

    !> Runs that are still to be estimated.
    pure type(monte_carlo_t) function some_runs(numbers) result(runs)
        integer, intent(in) :: numbers(:)    !! Of the runs

        runs%run = numbers
        allocate (runs%offset(3, size(numbers)), runs%converged(size(numbers)), runs%normalised(size(numbers)), runs%refused(0))
    end function some_runs

    pure subroutine keep(self, places)
        class(monte_carlo_t), intent(inout) :: self
        integer, intent(in) :: places(:)        !! Of those that stay

        self%run = self%run(places)
        self%offset = self%offset(:, places)
        self%converged = self%converged(places)
        self%normalised = self%normalised(places)
    end subroutine keep

    pure subroutine add(self, others)
        class(monte_carlo_t), intent(inout) :: self
        class(monte_carlo_t), intent(in) :: others      !! Other runs than these

        integer :: i
        integer, allocatable :: place_of(:)

        self%run = [self%run, others%run]
        self%offset = reshape([self%offset, others%offset], [3, size(self%run)])
        self%converged = [self%converged, others%converged]
        self%normalised = [self%normalised, others%normalised]
        do i = 1, size(others%refused)
            call append(self%refused, others%refused(i)%text)
        end do
        allocate (place_of(maxval([0, self%run])), source=0)
        place_of(self%run) = [(i, i=1, size(self%run))]
        call self%keep(pack(place_of, place_of > 0))
    end subroutine add

    subroutine do_run(self, i, error)
        class(runs_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        type(solution_t) :: solution

        associate (results => self%results, run => self%results%run(i))
            call observe(self%simulator, self%seed, run, observations, error, only_used_head=.true.)
            if (.not. allocated(error)) then
                if (associated(self%alteration)) &
                    call self%alteration%alter(self%simulator, self%seed, run, observations)
                call estimate_offset(self%algorithm, observations, self%options, solution, error)
            end if
            call add_context(error, 'run '//integer_text(run))
            if (allocated(error) .and. self%leaves_out) then
                self%refusal(i)%text = error%message
                deallocate (error)
                return
            end if
            if (allocated(error)) return
            results%offset(:, i) = solution%offset
            results%converged(i) = solution%converged
            results%normalised(i) = normalised_error(solution%offset - self%simulator%case%satellite%offset, &
                                                     solution%covariance)
            if (associated(self%recorder)) then
                !$omp critical (gracecg_monte_carlo_record)
                call self%recorder%record(run, solution%offset, solution%converged, results%normalised(i), error)
                !$omp end critical (gracecg_monte_carlo_record)
            end if
            self%done(i) = .not. allocated(error)
        end associate
    end subroutine do_run

    !> e^T C^-1 e, after scaling C to a unit diagonal; 0 without a covariance.
    pure real(dp) function normalised_error(deviation, covariance) result(square)
        real(dp), intent(in) :: deviation(3)        !! m
        real(dp), intent(in) :: covariance(3, 3)    !! m^2

        real(dp) :: sigma(3), scaled(3, 3), e(3)
        integer :: i

        square = 0
        sigma = [(sqrt(covariance(i, i)), i=1, 3)]
        if (.not. all(sigma > 0)) return
        scaled = covariance/(spread(sigma, 1, 3)*spread(sigma, 2, 3))
        e = deviation/sigma
        square = dot_product(e, matmul(inverse_3x3(scaled), e))
    end function normalised_error

    !> Statistics of a column of estimates. In millimetres, as the files have them, so that estimates
    !> read back from a file give the same statistics to the last bit.
    pure function statistics_of(offset_mm, true_mm) result(statistics)
        real(dp), intent(in) :: offset_mm(:, :)     !! (3, runs)
        real(dp), intent(in) :: true_mm(3)          !! True offset d, body axes, mm
        type(error_statistics_t) :: statistics

        real(dp) :: errors(3, size(offset_mm, 2))
        integer :: n

        n = size(errors, 2)
        errors = offset_mm - spread(true_mm, 2, n)
        statistics%rms = sqrt(sum(errors**2, 2)/n)
        statistics%mean = sum(errors, 2)/n
        statistics%deviation = sqrt(sum((errors - spread(statistics%mean, 2, n))**2, 2)/max(n - 1, 1))
    end function statistics_of

    !> Theory of a simulation with an algorithm, and its runs 1 to `runs`. Fails as `predict_errors` and `run_monte_carlo` do.
    subroutine study_errors(simulator, algorithm, options, seed, runs, threads, study, error, progress)
        type(simulator_t), intent(in) :: simulator
        character(*), intent(in) :: algorithm   !! One of ESTIMATOR_NAMES
        type(estimation_options_t), intent(in) :: options
        integer(i8), intent(in) :: seed         !! Of the random numbers
        integer, intent(in) :: runs, threads    !! How many, 0: theory alone; in parallel
        class(error_study_t), intent(inout) :: study
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress      !! Counts the runs

        type(monte_carlo_t) :: results
        type(prediction_t) :: prediction
        integer :: i

        call predict_errors(simulator, algorithm, options, prediction, error)
        if (allocated(error)) return
        study%predicted = prediction%rms
        study%runs = runs
        if (runs == 0) return
        call run_monte_carlo(simulator, algorithm, options, seed, [(i, i=1, runs)], threads, results, error, progress=progress)
        if (.not. allocated(error)) study%rms = rms_of_errors(results, simulator)
    end subroutine study_errors

    !> RMS errors of estimates, m; by millimetres, as the files have them.
    pure function rms_of_errors(results, simulator) result(rms)
        type(monte_carlo_t), intent(in) :: results
        type(simulator_t), intent(in) :: simulator      !! That they are of
        real(dp) :: rms(3)

        type(error_statistics_t) :: statistics

        statistics = statistics_of(results%offset/MILLIMETRE, simulator%case%satellite%offset/MILLIMETRE)
        rms = statistics%rms*MILLIMETRE
    end function rms_of_errors

    !> Predicts the RMS error of a case and algorithm without any random number: the covariance under
    !> the instruments' true noise spectra, the bias that is left without noise, and the response to
    !> the density wave, averaged over its phase. The response to the wave is linear, so two phases a
    !> quarter apart give the average over all.
    subroutine predict_errors(simulator, algorithm, options, prediction, error)
        type(simulator_t), intent(in) :: simulator
        character(*), intent(in) :: algorithm   !! One of ESTIMATOR_NAMES
        type(estimation_options_t), intent(in) :: options
        type(prediction_t), intent(out) :: prediction
        type(error_t), allocatable, intent(out) :: error

        type(solution_t) :: still, sine, cosine
        type(density_wave_t) :: wave
        integer :: i

        associate (random => simulator%case%density_wave_random)
            call estimate_without_noise(simulator, algorithm, options, density_wave_t(), .not. random, still, error)
            if (allocated(error)) return
            prediction%bias = still%offset - simulator%case%satellite%offset
            prediction%wave = 0
            if (random) then
                wave = simulator%case%density_wave
                wave%phase = 0
                call estimate_without_noise(simulator, algorithm, options, wave, .false., sine, error)
                if (allocated(error)) return
                wave%phase = PI/2
                ! the covariance of an estimator that responds to the wave is that with the wave
                call estimate_without_noise(simulator, algorithm, options, wave, .true., cosine, error)
                if (allocated(error)) return
                prediction%wave = sqrt(((sine%offset - still%offset)**2 + (cosine%offset - still%offset)**2)/2)
                still%covariance = cosine%covariance
            end if
        end associate
        prediction%noise = [(sqrt(still%covariance(i, i)), i=1, 3)]
        prediction%rms = sqrt(prediction%noise**2 + prediction%bias**2 + prediction%wave**2)
    end subroutine predict_errors

    subroutine estimate_without_noise(simulator, algorithm, options, wave, covariance, solution, error)
        type(simulator_t), intent(in) :: simulator
        character(*), intent(in) :: algorithm
        type(estimation_options_t), intent(in) :: options
        type(density_wave_t), intent(in) :: wave
        logical, intent(in) :: covariance       !! Is it wanted?
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        type(estimation_options_t) :: own

        call observe_without_noise(simulator, wave, observations)
        own = options
        own%covariance = covariance
        own%test_beliefs = .false.              ! without noise they would be contradicted
        own%largest_offset = 1e3_dp             ! m: a weak manoeuvre may find any
        own%optimal%noise = NOISE_GIVEN         ! there is none to estimate
        call estimate_offset(algorithm, observations, own, solution, error)
    end subroutine estimate_without_noise
end module gracecg_studies_monte_carlo
