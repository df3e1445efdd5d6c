!> A Monte Carlo campaign: cases by algorithms, whole or one shard of it, and how it compares with
!> theory and with Tables 6.1 and 6.2 of CSR-TM-00-01.
!>
!> Offsets stand in mm, as in the files, so that a campaign read back from its files gives the same
!> statistics to the last bit.
module gracecg_studies_campaign
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_progress, only: progress_t, tell, expect_pieces, is_stopped
    use gracecg_estimation_estimators, only: REPORT_ESTIMATORS
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_simulation_simulator, only: simulator_t, new_simulator
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_studies_monte_carlo, only: monte_carlo_t, some_runs, run_monte_carlo, run_recorder_t, &
        error_statistics_t, statistics_of, prediction_t, predict_errors
    use gracecg_studies_published, only: built_in_calibration, settings_checksum, published_rms, is_misprint, &
        allowed_by_fifteen_runs
    use gracecg_base_text, only: integer_text
    implicit none
    private
    public :: campaign_t, campaign_case_t, campaign_entry_t, campaign_agreement_t, new_campaign, add_case, run_case, &
        predict_entry, run_entry, runs_done, summarise, report_campaign, first_runs, agreement_of, shard_runs, &
        merge_campaigns, check_settings

    !> A case of a campaign.
    type :: campaign_case_t
        character(64) :: name = ''                  !! Of the case, as in the tables
        real(dp) :: offset(3) = 0                   !! True d, mm
        integer :: checksum = 0                     !! Of all its settings
        character(16) :: published = ''             !! Which case of the report it is; empty: none
    end type campaign_case_t

    !> One case with one algorithm: its estimates, mm, in the order of their runs, and what is made of them. Of a run that
    !> was read from a file `normalised` may be -1: not known.
    type, extends(monte_carlo_t) :: campaign_entry_t
        type(error_statistics_t) :: statistics      !! mm
        real(dp) :: predicted(3) = 0                !! RMS error by theory, mm
        real(dp) :: published(3) = 0                !! RMS error in the report, mm; 0: none
        real(dp) :: mean_normalised = 0
        !! Mean error squared in units of the estimates' own covariances; 0: not known or none
    end type campaign_entry_t

    !> Cases by algorithms, or the part of the runs that one shard has of them.
    type :: campaign_t
        integer(i8) :: seed = 1                         !! Of the random numbers
        integer :: runs = 0                         !! Of the whole: 1 to runs
        integer :: shard = 1, shards = 1            !! This is shard k of n
        character(16), allocatable :: algorithms(:) !! Each one of ESTIMATOR_NAMES
        type(campaign_case_t), allocatable :: cases(:)  !! The cases, in the order of the tables
        type(campaign_entry_t), allocatable :: entries(:, :)    !! (algorithm, case)
    end type campaign_t

    !> How a campaign, theory and the published values agree.
    type :: campaign_agreement_t
        integer :: published = 0            !! Values of the report that there are
        integer :: allowed = 0              !! That 15 runs allow if theory is right, 95 %
        logical :: misprint = .false.       !! The misprinted value is among them
        integer :: not_converged = 0        !! Estimates
        integer :: refused = 0              !! Runs without an estimate
        real(dp) :: worst_difference = 0    !! Of an RMS from theory, relative
    end type campaign_agreement_t

    real(dp), parameter :: AGREEMENT = 1e-6_dp
    !! Relative difference up to which two results of one run agree. On one machine they are equal;
    !! another processor may round otherwise

contains

    !> An empty campaign.
    function new_campaign(algorithms, cases, seed, runs, shard, shards) result(campaign)
        character(*), intent(in) :: algorithms(:)   !! Each one of ESTIMATOR_NAMES
        integer, intent(in) :: cases            !! Their number
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, shard, shards    !! As the components of the same names
        type(campaign_t) :: campaign

        integer :: a, i

        campaign%seed = seed
        campaign%runs = runs
        campaign%shard = shard
        campaign%shards = shards
        campaign%algorithms = algorithms
        allocate (campaign%cases(cases), campaign%entries(size(algorithms), cases))
        do i = 1, cases
            do a = 1, size(algorithms)
                campaign%entries(a, i)%monte_carlo_t = some_runs([integer ::])
            end do
        end do
    end function new_campaign

    !> The runs of a shard: those of 1 to `runs` with mod(run - 1, shards) = shard - 1.
    pure function shard_runs(campaign) result(runs)
        type(campaign_t), intent(in) :: campaign
        integer, allocatable :: runs(:)

        integer :: i

        runs = [(i, i=campaign%shard, campaign%runs, campaign%shards)]
    end function shard_runs

    !> The runs of the shard that an entry does not have yet.
    pure function missing_runs(campaign, a, i) result(runs)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: a, i         !! Numbers of algorithm and case
        integer, allocatable :: runs(:)

        logical, allocatable :: missing(:)
        integer :: k

        allocate (missing(campaign%runs), source=.false.)
        missing(shard_runs(campaign)) = .true.
        missing(campaign%entries(a, i)%run) = .false.
        runs = pack([(k, k=1, campaign%runs)], missing)
    end function missing_runs

    !> How many runs the entries have, all together.
    pure integer function runs_done(campaign)
        type(campaign_t), intent(in) :: campaign

        integer :: a, i

        runs_done = sum([((size(campaign%entries(a, i)%run), a=1, size(campaign%algorithms)), i=1, size(campaign%cases))])
    end function runs_done

    !> Makes a case number i of the campaign. Fails when its name is another one's, or has a comma.
    subroutine add_case(campaign, i, calibration, error)
        type(campaign_t), intent(inout) :: campaign
        integer, intent(in) :: i    !! Its number in the campaign
        type(calibration_t), intent(in) :: calibration
        type(error_t), allocatable, intent(out) :: error

        integer :: checksum

        if (any(campaign%cases(:i - 1)%name == calibration%case%name)) then
            call fail(error, 'two cases have the name "'//trim(calibration%case%name)// &
                      '": their rows could not be told apart; change `name` in the namelist file')
        else if (scan(trim(calibration%case%name), ',"') > 0) then
            call fail(error, 'the name of a case must have no comma and no quotation mark: '// &
                      trim(calibration%case%name))
        else
            call settings_checksum(calibration, checksum, error)
        end if
        if (allocated(error)) return
        associate (case => calibration%case)
            campaign%cases(i) = campaign_case_t(case%name, case%satellite%offset/MILLIMETRE, checksum)
            call built_in_calibration(trim(case%name), checksum, campaign%cases(i)%published)
        end associate
    end subroutine add_case

    !> Tables 6.1 and 6.2: the six cases of the report with its four algorithms.
    subroutine report_campaign(seed, runs, threads, campaign, error, progress)
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads      !! Runs of each case; in parallel
        type(campaign_t), intent(out) :: campaign
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        integer :: i

        campaign = new_campaign(REPORT_ESTIMATORS, size(REPORT_CASE_NAMES), seed, runs, 1, 1)
        call expect_pieces(progress, size(campaign%entries)*runs, 'runs')
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
            call run_entry(campaign, a, i, simulator, calibration%options, threads, error, progress)
            if (allocated(error)) return
            associate (refused => campaign%entries(a, i)%refused)
                if (size(refused) > 0) call fail(error, refused(1)%text)
            end associate
        end do
    end subroutine run_case

    !> The campaign of the first n runs: a run's numbers do not depend on the others.
    function first_runs(campaign, n) result(first)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: n                        !! At most the runs there are
        type(campaign_t) :: first

        integer :: a, i, k

        first = campaign
        first%runs = n
        do i = 1, size(first%cases)
            do a = 1, size(first%algorithms)
                call first%entries(a, i)%keep([(k, k=1, n)])
                call summarise(first, a, i)
            end do
        end do
    end function first_runs

    !> Theory of case i with algorithm a, where it is not there yet.
    subroutine predict_entry(campaign, a, i, simulator, options, error)
        type(campaign_t), intent(inout) :: campaign
        integer, intent(in) :: a, i                     !! Numbers of algorithm and case
        type(simulator_t), intent(in) :: simulator      !! Of case i
        type(estimation_options_t), intent(in) :: options   !! Of its estimates
        type(error_t), allocatable, intent(out) :: error

        type(prediction_t) :: prediction

        if (any(campaign%entries(a, i)%predicted > 0)) return
        call predict_errors(simulator, trim(campaign%algorithms(a)), options, prediction, error)
        if (.not. allocated(error)) campaign%entries(a, i)%predicted = prediction%rms/MILLIMETRE
    end subroutine predict_entry

    !> Theory, and the runs of the shard that are missing, of case i with algorithm a; runs whose estimate fails are left out.
    !> Fails when all fail, and when the listener wants to stop; the entry has the runs that were done all the same.
    subroutine run_entry(campaign, a, i, simulator, options, threads, error, progress, recorder)
        type(campaign_t), intent(inout) :: campaign
        integer, intent(in) :: a, i                     !! Numbers of algorithm and case
        type(simulator_t), intent(in) :: simulator      !! Of case i
        type(estimation_options_t), intent(in) :: options   !! Of its estimates
        integer, intent(in) :: threads                  !! How many to use
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress      !! Counts the runs
        class(run_recorder_t), intent(inout), optional :: recorder  !! Gets every run

        type(monte_carlo_t) :: results

        call tell(progress, trim(campaign%cases(i)%name)//', '//trim(campaign%algorithms(a)))
        call predict_entry(campaign, a, i, simulator, options, error)
        if (allocated(error)) return
        call run_monte_carlo(simulator, trim(campaign%algorithms(a)), options, campaign%seed, &
                             missing_runs(campaign, a, i), threads, results, error, progress=progress, &
                             recorder=recorder, leave_out=.true.)
        if (allocated(error) .and. .not. is_stopped(progress)) return
        results%offset = results%offset/MILLIMETRE
        call campaign%entries(a, i)%add(results)
        call summarise(campaign, a, i)
    end subroutine run_entry

    !> Statistics of an entry whose estimates are there, and its published values.
    subroutine summarise(campaign, a, i)
        type(campaign_t), intent(inout) :: campaign
        integer, intent(in) :: a, i !! Numbers of algorithm and case

        associate (entry => campaign%entries(a, i), case => campaign%cases(i))
            entry%mean_normalised = 0
            if (size(entry%run) > 0) entry%statistics = statistics_of(entry%offset, case%offset)
            if (size(entry%run) > 0 .and. all(entry%normalised >= 0)) &
                entry%mean_normalised = sum(entry%normalised)/size(entry%run)
            entry%published = published_rms(trim(case%published), trim(campaign%algorithms(a)))
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
                    agreement%refused = agreement%refused + size(entry%refused)
                    if (size(entry%run) == 0) cycle
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

    !> The union of the runs, in their order, with its statistics. A run that several parts have is
    !> taken from the first of them.
    !>
    !> Fails when seed, number of runs, cases or algorithms of the parts differ, when two parts
    !> contradict each other, or when some entry is left without any run.
    subroutine merge_campaigns(parts, names, whole, missing, error)
        type(campaign_t), intent(in) :: parts(:)    !! At least one
        character(*), intent(in) :: names(:)        !! Of their files, for messages
        type(campaign_t), intent(out) :: whole
        integer, intent(out) :: missing             !! Runs that no part has, over all entries
        type(error_t), allocatable, intent(out) :: error

        integer :: p, a, i

        missing = 0
        associate (first => parts(1))
            do p = 2, size(parts)
                call check_settings(first, parts(p), trim(names(1))//' and '//trim(names(p)), error)
                if (allocated(error)) return
            end do
            whole = new_campaign(first%algorithms, size(first%cases), first%seed, first%runs, 1, 1)
            whole%cases = first%cases
        end associate
        do i = 1, size(whole%cases)
            do a = 1, size(whole%algorithms)
                call merge_entry(parts, names, a, i, whole, error)
                if (allocated(error)) return
                missing = missing + whole%runs - size(whole%entries(a, i)%run)
                call summarise(whole, a, i)
            end do
        end do
    end subroutine merge_campaigns

    !> Fails unless two campaigns have the same seed, runs, cases, settings and algorithms.
    subroutine check_settings(first, other, files, error)
        type(campaign_t), intent(in) :: first, other
        character(*), intent(in) :: files           !! What they are, for messages: 'a.csv and b.csv'
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        if (first%seed /= other%seed) then
            call fail(error, files//' have different seeds: '//integer_text(first%seed)//' and '// &
                      integer_text(other%seed))
        else if (first%runs /= other%runs) then
            call fail(error, files//' are of campaigns of '//integer_text(first%runs)//' and '// &
                      integer_text(other%runs)//' runs')
        else if (size(first%cases) /= size(other%cases) .or. &
                 size(first%algorithms) /= size(other%algorithms)) then
            call fail(error, files//' have different cases or algorithms')
        else if (any(first%cases%name /= other%cases%name) .or. &
                 any(first%algorithms /= other%algorithms)) then
            call fail(error, files//' have different cases or algorithms')
        end if
        if (allocated(error)) return
        do i = 1, size(first%cases)
            if (first%cases(i)%checksum == other%cases(i)%checksum) cycle
            call fail(error, files//' have different settings of the case '//trim(first%cases(i)%name))
            return
        end do
    end subroutine check_settings

    !> The runs of case i with algorithm a, from all parts.
    subroutine merge_entry(parts, names, a, i, whole, error)
        type(campaign_t), intent(in) :: parts(:)
        character(*), intent(in) :: names(:)
        integer, intent(in) :: a, i
        type(campaign_t), intent(inout) :: whole
        type(error_t), allocatable, intent(out) :: error

        type(campaign_entry_t) :: new
        integer, dimension(whole%runs) :: source, place     ! the part that has a run, and where it stands in it; 0: none
        integer :: p, k

        source = 0
        do p = 1, size(parts)
            new = parts(p)%entries(a, i)
            do k = 1, size(new%run)
                associate (run => new%run(k))
                    if (source(run) == 0) then
                        source(run) = p
                        place(run) = k
                    else if (.not. same_estimate(parts(source(run))%entries(a, i), place(run), new, k)) then
                        call fail(error, trim(names(source(run)))//' and '//trim(names(p))// &
                                  ' contradict each other: '//trim(whole%cases(i)%name)//', '// &
                                  trim(whole%algorithms(a))//', run '//integer_text(run))
                        return
                    end if
                end associate
            end do
            call new%keep(pack([(k, k=1, size(new%run))], source(new%run) == p))
            call whole%entries(a, i)%add(new)
        end do
        if (all(source == 0)) &
            call fail(error, 'no file has a run of '//trim(whole%cases(i)%name)//', '//trim(whole%algorithms(a)))
        whole%entries(a, i)%predicted = parts(1)%entries(a, i)%predicted
    end subroutine merge_entry

    pure logical function same_estimate(first, i, other, k) result(same)
        type(campaign_entry_t), intent(in) :: first, other
        integer, intent(in) :: i, k         !! Places of the run in them

        same = all(abs(first%offset(:, i) - other%offset(:, k)) <= &
                   AGREEMENT*max(abs(first%offset(:, i)), abs(other%offset(:, k)))) .and. &
               (first%converged(i) .eqv. other%converged(k))
    end function same_estimate
end module gracecg_studies_campaign
