!> A Monte Carlo campaign: cases by algorithms, whole or one shard of it, and how it compares with
!> theory and with Tables 6.1 and 6.2 of CSR-TM-00-01.
!>
!> Offsets stand in mm, as in the files, so that a campaign read back from its files gives the same
!> statistics to the last bit.
module gracecg_studies_campaign
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_progress, only: progress_t, tell
    use gracecg_base_text, only: integer_text
    use gracecg_estimation_estimators, only: REPORT_ESTIMATORS
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_simulation_simulator, only: simulator_t, new_simulator
    use gracecg_planning_calibration, only: calibration_t, find_calibration, calibration_text
    use gracecg_studies_monte_carlo, only: monte_carlo_t, run_monte_carlo, error_statistics_t, statistics_of, &
        prediction_t, predict_errors
    use gracecg_studies_published_rms, only: published_rms, is_misprint, allowed_by_fifteen_runs
    implicit none
    private
    public :: campaign_t, campaign_case_t, campaign_entry_t, campaign_agreement_t
    public :: new_campaign, add_case, run_case, run_entry, summarise, report_campaign, first_runs, agreement_of, &
        shard_runs

    !> A case of a campaign.
    type :: campaign_case_t
        character(64) :: name = ''                  !! Of the case, as in the tables
        real(dp) :: offset(3) = 0                   !! True d, mm
        integer :: checksum = 0                     !! Of all its settings
    end type campaign_case_t

    !> One case with one algorithm.
    type :: campaign_entry_t
        integer, allocatable :: run(:)              !! Numbers of the runs, increasing
        real(dp), allocatable :: offset(:, :)       !! Estimates, (3, runs), mm
        logical, allocatable :: converged(:)        !! (runs)
        type(error_statistics_t) :: statistics      !! mm
        real(dp) :: predicted(3) = 0                !! RMS error by theory, mm
        real(dp) :: published(3) = 0                !! RMS error in the report, mm; 0: none
        real(dp) :: normalised = 0
        !! Mean error squared in units of the estimates' own covariances; 0: not known
    end type campaign_entry_t

    !> Cases by algorithms, or the part of the runs that one shard has of them.
    type :: campaign_t
        integer :: seed = 1                         !! Of the random numbers
        integer :: runs = 0                         !! Of the whole: 1 to runs
        integer :: shard = 1, shards = 1            !! This is shard k of n
        character(16), allocatable :: algorithms(:) !! Each one of ESTIMATOR_NAMES
        type(campaign_case_t), allocatable :: cases(:)  !! The cases, in the order of the tables
        type(campaign_entry_t), allocatable :: entries(:, :)    !! (algorithm, case)
        character(8) :: version = ''                !! Of the program whose file it comes from; blank: of none
    end type campaign_t

    !> How a campaign, theory and the published values agree.
    type :: campaign_agreement_t
        integer :: published = 0            !! Values of the report that there are
        integer :: allowed = 0              !! That 15 runs allow if theory is right, 95 %
        logical :: misprint = .false.       !! The misprinted value is among them
        integer :: not_converged = 0        !! Estimates
        real(dp) :: worst_difference = 0    !! Of an RMS from theory, relative
    end type campaign_agreement_t

contains

    !> An empty campaign.
    function new_campaign(algorithms, cases, seed, runs, shard, shards) result(campaign)
        character(*), intent(in) :: algorithms(:)   !! Each one of ESTIMATOR_NAMES
        integer, intent(in) :: cases            !! Their number
        integer, intent(in) :: seed, runs, shard, shards    !! As the components of the same names
        type(campaign_t) :: campaign

        campaign%seed = seed
        campaign%runs = runs
        campaign%shard = shard
        campaign%shards = shards
        campaign%algorithms = algorithms
        allocate (campaign%cases(cases), campaign%entries(size(algorithms), cases))
    end function new_campaign

    !> The runs of a shard: those of 1 to `runs` with mod(run - 1, shards) = shard - 1.
    pure function shard_runs(campaign) result(runs)
        type(campaign_t), intent(in) :: campaign
        integer, allocatable :: runs(:)

        integer :: i

        runs = [(i, i=campaign%shard, campaign%runs, campaign%shards)]
    end function shard_runs

    !> Makes a case number i of the campaign. Fails when its name is another one's, or has a comma.
    subroutine add_case(campaign, i, calibration, error)
        type(campaign_t), intent(inout) :: campaign
        integer, intent(in) :: i    !! Its number in the campaign
        type(calibration_t), intent(in) :: calibration
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: text

        if (any(campaign%cases(:i - 1)%name == calibration%case%name)) then
            call fail(error, 'two cases have the name "'//trim(calibration%case%name)// &
                      '": their rows could not be told apart; change `name` in the namelist file')
        else if (scan(trim(calibration%case%name), ',"') > 0) then
            call fail(error, 'the name of a case must have no comma and no quotation mark: '// &
                      trim(calibration%case%name))
        else
            call calibration_text(calibration, text, error)
        end if
        if (allocated(error)) return
        associate (case => calibration%case)
            campaign%cases(i) = campaign_case_t(case%name, case%satellite%offset/MILLIMETRE, checksum(text))
        end associate
    end subroutine add_case

    !> A number that differs between texts, but for one chance in two thousand million.
    pure integer function checksum(text)
        character(*), intent(in) :: text

        integer(i8), parameter :: PRIME = 2147483647_i8, FACTOR = 48271_i8
        integer(i8) :: total
        integer :: i

        total = 1
        do i = 1, len(text)
            total = mod(total*FACTOR + iachar(text(i:i)), PRIME)
        end do
        checksum = int(total)
    end function checksum

    !> Tables 6.1 and 6.2: the six cases of the report with its four algorithms.
    subroutine report_campaign(seed, runs, threads, campaign, error, progress)
        integer, intent(in) :: seed, runs, threads      !! First seed; runs of each case; in parallel
        type(campaign_t), intent(out) :: campaign
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        integer :: i

        campaign = new_campaign(REPORT_ESTIMATORS, size(REPORT_CASE_NAMES), seed, runs, 1, 1)
        do i = 1, size(REPORT_CASE_NAMES)
            call find_calibration(REPORT_CASE_NAMES(i), calibration, error)
            if (.not. allocated(error)) call new_simulator(calibration%case, simulator, error)
            if (.not. allocated(error)) call run_case(campaign, i, calibration, simulator, threads, error, progress)
            if (allocated(error)) return
        end do
    end subroutine report_campaign

    !> Makes a case number i of the campaign and runs it with all algorithms.
    subroutine run_case(campaign, i, calibration, simulator, threads, error, progress)
        type(campaign_t), intent(inout) :: campaign
        integer, intent(in) :: i                        !! Number of the case
        type(calibration_t), intent(in) :: calibration  !! The case, and how it is estimated
        type(simulator_t), intent(in) :: simulator      !! Of the case
        integer, intent(in) :: threads                  !! How many to use
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        integer :: a

        call add_case(campaign, i, calibration, error)
        do a = 1, size(campaign%algorithms)
            if (allocated(error)) return
            call tell(progress, 'campaign: '//trim(campaign%cases(i)%name)//', '//trim(campaign%algorithms(a))//', '// &
                      integer_text(size(shard_runs(campaign)))//' runs')
            call run_entry(campaign, a, i, simulator, calibration%options, threads, error)
        end do
    end subroutine run_case

    !> The campaign of the first n runs: a run's numbers do not depend on the others.
    function first_runs(campaign, n) result(first)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: n                        !! At most the runs there are
        type(campaign_t) :: first

        integer :: a, i

        first = campaign
        first%runs = n
        do i = 1, size(first%cases)
            do a = 1, size(first%algorithms)
                associate (entry => first%entries(a, i))
                    entry%run = entry%run(:n)
                    entry%offset = entry%offset(:, :n)
                    entry%converged = entry%converged(:n)
                end associate
                call summarise(first, a, i)
            end do
        end do
    end function first_runs

    !> Theory, and the shard's runs, of case i with algorithm a. Fails when a run fails.
    subroutine run_entry(campaign, a, i, simulator, options, threads, error)
        type(campaign_t), intent(inout) :: campaign
        integer, intent(in) :: a, i                     !! Numbers of algorithm and case
        type(simulator_t), intent(in) :: simulator      !! Of case i
        type(estimation_options_t), intent(in) :: options   !! Of its estimates
        integer, intent(in) :: threads                  !! How many to use
        type(error_t), allocatable, intent(out) :: error

        type(prediction_t) :: prediction
        type(monte_carlo_t) :: results
        character(:), allocatable :: algorithm

        algorithm = trim(campaign%algorithms(a))
        call predict_errors(simulator, algorithm, options, prediction, error)
        if (allocated(error)) return
        call run_monte_carlo(simulator, algorithm, options, campaign%seed, shard_runs(campaign), threads, results, &
                             error)
        if (allocated(error)) return
        associate (entry => campaign%entries(a, i))
            entry%run = results%run
            entry%offset = results%offset/MILLIMETRE
            entry%converged = results%converged
            entry%predicted = prediction%rms/MILLIMETRE
            entry%normalised = sum(results%normalised)/size(results%normalised)
        end associate
        call summarise(campaign, a, i)
    end subroutine run_entry

    !> Statistics of an entry whose estimates are there, and its published values.
    subroutine summarise(campaign, a, i)
        type(campaign_t), intent(inout) :: campaign
        integer, intent(in) :: a, i !! Numbers of algorithm and case

        associate (entry => campaign%entries(a, i), case => campaign%cases(i))
            entry%statistics = statistics_of(entry%offset, case%offset)
            entry%published = published_rms(trim(case%name), trim(campaign%algorithms(a)))
        end associate
    end subroutine summarise

    !> The agreement of all entries: counts over cases, algorithms and axes.
    pure function agreement_of(campaign) result(agreement)
        type(campaign_t), intent(in) :: campaign
        type(campaign_agreement_t) :: agreement

        integer :: a, i

        do i = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                associate (entry => campaign%entries(a, i))
                    agreement%published = agreement%published + count(entry%published > 0)
                    agreement%allowed = agreement%allowed + &
                                      count(entry%published > 0 .and. &
                                            allowed_by_fifteen_runs(entry%published, entry%predicted))
                    agreement%misprint = agreement%misprint .or. any(is_misprint(entry%published))
                    agreement%not_converged = agreement%not_converged + count(.not. entry%converged)
                    agreement%worst_difference = &
                        max(agreement%worst_difference, maxval(abs(entry%statistics%rms/entry%predicted - 1)))
                end associate
            end do
        end do
    end function agreement_of
end module gracecg_studies_campaign
