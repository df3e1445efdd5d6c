!> gracecg montecarlo: Tables 6.1 and 6.2 of CSR-TM-00-01, ours beside the published values and the
!> theoretical prediction; and gracecg merge, which puts the shards of such a campaign together.
module gracecg_cli_montecarlo
    use gracecg_base_text, only: parse_integer
    use gracecg_files_file, only: file_exists, is_device
    use gracecg_files_run_record, only: note_file, UPDATED
    use gracecg_estimation_estimators, only: REPORT_ESTIMATORS
    use gracecg_simulation_simulator, only: simulator_t, error_switches_t, new_switched_simulator, switch_off, &
        SOURCE_NAMES
    use gracecg_studies_campaign, only: campaign_t, new_campaign, add_case, predict_entry, run_entry, shard_runs, &
        runs_done, check_settings, merge_campaigns
    use gracecg_studies_campaign_files, only: read_runs, journal_t, journal_path
    use gracecg_cli_campaign_tables, only: show_campaign, publish_campaign, read_campaign_files, REPORT_RUNS
    use gracecg_cli_process, only: catch_interruption, caught_signal, signal_name
    use gracecg_cli_work
    implicit none
    private
    public :: declare_montecarlo, run_montecarlo, declare_merge, run_merge

    character(*), parameter :: COMMAND = 'montecarlo', MERGE_COMMAND = 'merge'
    integer, parameter :: MOST_FILES = 100000   !! That are merged
    integer, parameter :: MOST_SHOWN = 20       !! Shards that a message names

    !> What the user asks for.
    type :: request_t
        type(study_t) :: study
        integer :: shard = 1, shards = 1
        type(error_switches_t) :: switches
        character(:), allocatable :: without    !! Error sources that are switched off, as given; empty: none
        character(:), allocatable :: runs_file  !! Empty: none
        character(:), allocatable :: resumed_file       !! Runs file of a campaign to go on with; empty: none
        logical :: keeps = .false.              !! There is a journal of the runs
    end type request_t

contains

    !> Arguments and help of `gracecg montecarlo`.
    subroutine declare_montecarlo(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe(COMMAND, '[CASE ...]', 0, MOST_CASES, &
                                'Simulates and estimates many calibrations of each case (default all, the six '// &
                                'built-in ones) and prints the RMS error of the CG offset in the layout of '// &
                                'Tables 6.1 and 6.2 of CSR-TM-00-01, beside the published values and the prediction of a '// &
                                'covariance analysis. A large campaign can be done in shards, on as many '// &
                                'machines as there are, and put together by gracecg merge. With --runs-out '// &
                                'it may be stopped at any moment, by Ctrl-C or otherwise: --resume goes on.', &
                                'gracecg montecarlo front-3 back-3 --algorithms assest-fde --runs 100')
        call add_study_options(arguments, '--cases --algorithms --runs', join(REPORT_ESTIMATORS, ','), integer_text(REPORT_RUNS))
        call arguments%add_option('--shard', 'K/N', 'do only every N-th run, from run K on; --runs stays that '// &
                                  'of the whole campaign', default='1/1')
        call arguments%add_option('--without', 'LIST', 'error sources to switch off in the simulation, of '// &
                                  join(SOURCE_NAMES, ', ')//' (the three others that are no noise)', choices=SOURCE_NAMES)
        call add_study_options(arguments, '--seed --threads --out')
        call arguments%add_option('--runs-out', 'FILE', 'CSV file for the estimate of every run; while the campaign '// &
                                  'is at work, the runs that are done stand in FILE.part')
        call arguments%add_option('--resume', 'FILE', 'go on with a campaign that was interrupted: the same command '// &
                                  'line, and the FILE of its --runs-out; only the missing runs are done')
        call add_study_options(arguments, '--format --options')
    end subroutine declare_montecarlo

    !> The work of `gracecg montecarlo`.
    subroutine run_montecarlo(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(request_t) :: request
        type(campaign_t) :: campaign
        type(simulator_t), allocatable :: simulators(:)
        type(journal_t) :: journal
        type(error_t), allocatable :: incomplete
        character(:), allocatable :: path       ! of the journal

        call read_request(arguments, request, console, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        call catch_interruption()
        call prepare_cases(request, simulators, campaign, error)
        if (.not. allocated(error)) call prepare_theory(request%study, simulators, campaign, console, error)
        if (request%resumed_file == request%runs_file) then
            call note_file(request%runs_file, UPDATED)
            call note_file(journal_path(request%runs_file), UPDATED)
        end if
        if (.not. allocated(error) .and. request%resumed_file /= '') call resume(request%resumed_file, campaign, console, &
                                                                                 error)
        if (.not. allocated(error) .and. request%keeps) then
            path = journal_path(request%runs_file)
            if (file_exists(path) .and. request%resumed_file /= request%runs_file) then
                call fail(error, path//' has runs of a campaign that was interrupted: go on with it by --resume '// &
                          request%runs_file//', or remove it')
            else
                call journal%begin(path, campaign, COMMAND, error)
            end if
        end if
        if (allocated(error)) return
        call run_all(request, simulators, campaign, journal, console, error)
        if (allocated(error) .and. .not. console%stops()) return
        if (allocated(error)) call move_alloc(error, incomplete)
        if (request%without /= '') call console%line('error sources switched off here: '//request%without// &
                                                     '; the report''s values have them all')
        if (runs_done(campaign) > 0) call show_campaign(campaign, console)
        if (allocated(incomplete)) then
            call fail(error, stop_text(arguments, request, campaign))
            return
        end if
        call publish_campaign(campaign, COMMAND, request%study%path, request%runs_file, console, error)
        if (request%keeps .and. .not. allocated(error)) call journal%remove()
    end subroutine run_montecarlo

    !> Simulators of all cases, and the campaign without any run.
    subroutine prepare_cases(request, simulators, campaign, error)
        type(request_t), intent(inout) :: request       !! Its cases: with what is switched off in the end
        type(simulator_t), allocatable, intent(out) :: simulators(:)
        type(campaign_t), intent(out) :: campaign
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        associate (study => request%study)
            campaign = new_campaign(padded(study%algorithms), size(study%calibrations), study%seed, study%runs, &
                                    request%shard, request%shards)
            allocate (simulators(size(study%calibrations)))
            do i = 1, size(simulators)
                call new_switched_simulator(study%calibrations(i)%case, request%switches, simulators(i), error)
                if (allocated(error)) return
                study%calibrations(i)%case = simulators(i)%case
                call add_case(campaign, i, study%calibrations(i), error)
                if (allocated(error)) return
            end do
        end associate
    end subroutine prepare_cases

    !> Theory of all entries.
    subroutine prepare_theory(study, simulators, campaign, console, error)
        type(study_t), intent(in) :: study
        type(simulator_t), intent(in) :: simulators(:)
        type(campaign_t), intent(inout) :: campaign
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        integer :: a, i

        call console%expect(size(campaign%entries), 'predictions')
        do i = 1, size(simulators)
            do a = 1, size(campaign%algorithms)
                if (console%stops()) then
                    call fail(error, 'stopped by '//trim(signal_name(caught_signal()))//' before the first run')
                else
                    call tell(console, 'theory, '//trim(campaign%cases(i)%name)//', '//trim(campaign%algorithms(a)))
                    call predict_entry(campaign, a, i, simulators(i), study%calibrations(i)%options, error)
                end if
                if (allocated(error)) return
                call console%advance()
            end do
        end do
    end subroutine prepare_theory

    !> Takes the runs of a campaign that was interrupted. Fails when it was another one.
    subroutine resume(path, campaign, console, error)
        character(*), intent(in) :: path            !! Of its runs file
        type(campaign_t), intent(inout) :: campaign
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(campaign_t) :: former
        character(:), allocatable :: found
        integer :: a, i

        found = journal_path(path)
        if (.not. file_exists(found)) found = path
        if (.not. file_exists(found)) then
            call fail(error, 'option --resume: there is no '//path//', and no '//journal_path(path)//' of a campaign '// &
                      'that was interrupted; leave --resume out to begin')
            return
        end if
        call read_runs(found, former, error)
        if (.not. allocated(error)) call check_settings(campaign, former, 'this command and '//found, error)
        if (allocated(error)) return
        if (campaign%shard /= former%shard .or. campaign%shards /= former%shards) then
            call fail(error, 'this command and '//found//' have different shards, of the file '// &
                      integer_text(former%shard)//'/'//integer_text(former%shards))
            return
        end if
        do i = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                campaign%entries(a, i)%monte_carlo_t = former%entries(a, i)%monte_carlo_t
            end do
        end do
        call console%message(found//' has '//integer_text(runs_done(campaign))//' of '// &
                             integer_text(runs_wanted(campaign))//' runs: going on with the others')
    end subroutine resume

    integer function runs_wanted(campaign)
        type(campaign_t), intent(in) :: campaign

        runs_wanted = size(campaign%entries)*size(shard_runs(campaign))
    end function runs_wanted

    !> The runs of all cases and algorithms.
    subroutine run_all(request, simulators, campaign, journal, console, error)
        type(request_t), intent(in) :: request
        type(simulator_t), intent(in) :: simulators(:)
        type(campaign_t), intent(inout) :: campaign
        type(journal_t), intent(inout) :: journal
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        integer :: a, i

        call console%expect(runs_wanted(campaign), 'runs', runs_done(campaign))
        do i = 1, size(simulators)
            associate (options => request%study%calibrations(i)%options, threads => request%study%threads)
                do a = 1, size(campaign%algorithms)
                    if (request%keeps) then
                        call journal%begin_entry(campaign, a, i)
                        call run_entry(campaign, a, i, simulators(i), options, threads, error, console, journal)
                    else
                        call run_entry(campaign, a, i, simulators(i), options, threads, error, console)
                    end if
                    if (allocated(error)) return
                end do
            end associate
        end do
    end subroutine run_all

    !> What was done when the command was stopped, and how to go on.
    function stop_text(arguments, request, campaign) result(text)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(in) :: request
        type(campaign_t), intent(in) :: campaign
        character(:), allocatable :: text

        text = 'stopped by '//trim(signal_name(caught_signal()))//': '//integer_text(runs_done(campaign))//' of '// &
               integer_text(runs_wanted(campaign))//' runs are done'
        if (request%keeps) then
            text = text//', and kept in '//journal_path(request%runs_file)//'; to go on:'//new_line('a')//'  '// &
                   arguments%command_line()
            if (.not. arguments%has('--resume')) text = text//' --resume '//request%runs_file
        else
            text = text//', and no file keeps them: --runs-out FILE would'
        end if
    end function stop_text

    subroutine read_request(arguments, request, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(out) :: request
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(inout) :: misuse
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: names(:)
        character(:), allocatable :: table_file
        integer :: runs, i

        call arguments%get('--runs', runs, misuse)
        call read_shard(arguments, runs, request, misuse)
        call arguments%get('--without', names, misuse)
        request%without = join(padded(names), ',')
        do i = 1, size(names)
            if (.not. allocated(misuse)) call switch_off(request%switches, names(i)%text, misuse)
        end do
        call read_campaign_files(arguments, table_file, request%runs_file, misuse)
        call arguments%get('--resume', request%resumed_file, misuse)
        if (request%runs_file == '') request%runs_file = request%resumed_file
        request%keeps = request%runs_file /= '' .and. .not. is_device(request%runs_file)
        if (.not. allocated(misuse)) call check_writable(request%runs_file, error)
        if (.not. allocated(error)) call take_study(arguments, 'all', console, request%study, misuse, error)
    end subroutine read_request

    subroutine read_shard(arguments, runs, request, misuse)
        type(arguments_t), intent(in) :: arguments
        integer, intent(in) :: runs             !! Of the whole campaign
        type(request_t), intent(inout) :: request
        type(error_t), allocatable, intent(inout) :: misuse

        character(:), allocatable :: text
        integer :: slash
        logical :: ok(2)

        call arguments%get('--shard', text, misuse)
        slash = index(text, '/')
        call parse_integer(text(:slash - 1), request%shard, ok(1))
        call parse_integer(text(slash + 1:), request%shards, ok(2))
        call refuse_if(slash == 0 .or. .not. all(ok) .or. request%shard < 1 .or. request%shard > request%shards, &
                       'option --shard: "'//text//'" is not K/N with whole numbers, K from 1 to N', misuse)
        call refuse_if(request%shard > runs, &
                       'option --shard: shard '//integer_text(request%shard)//'/'//integer_text(request%shards)//' of '// &
                       integer_text(runs)//' runs has none; there are as many shards as runs at most', misuse)
    end subroutine read_shard

    !> Arguments and help of `gracecg merge`.
    subroutine declare_merge(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe(MERGE_COMMAND, 'FILE ...', 1, MOST_FILES, &
                                'Puts the shards of a campaign together: files that gracecg montecarlo '// &
                                '--shard K/N --runs-out FILE wrote. Table and files are those of the whole '// &
                                'campaign, to the last digit. Runs that no file has are reported, '// &
                                'with the shards they are of; a run '// &
                                'that several files have counts once.', &
                                'gracecg montecarlo front-3 --runs 20 --shard 1/2 --runs-out '// &
                                'shard1.csv'//new_line('a')// &
                                'gracecg montecarlo front-3 --runs 20 --shard 2/2 --runs-out '// &
                                'shard2.csv'//new_line('a')// &
                                'gracecg merge shard1.csv shard2.csv --out table.csv')
        call add_study_options(arguments, '--out')
        call arguments%add_option('--runs-out', 'FILE', 'CSV file for the estimate of every run')
        call add_study_options(arguments, '--format')
    end subroutine declare_merge

    !> The work of `gracecg merge`.
    subroutine run_merge(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(campaign_t), allocatable :: parts(:)
        type(campaign_t) :: whole
        type(string_t), allocatable :: names(:)
        character(:), allocatable :: table_file, runs_file
        integer :: i, missing

        call read_campaign_files(arguments, table_file, runs_file, misuse)
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return
        call check_writable(table_file, error)
        if (.not. allocated(error)) call check_writable(runs_file, error)
        if (allocated(error)) return

        names = arguments%words
        allocate (parts(size(names)))
        do i = 1, size(parts)
            call read_runs(names(i)%text, parts(i), error)
            if (allocated(error)) return
        end do
        call merge_campaigns(parts, padded(names), whole, missing, error)
        if (allocated(error)) return
        call show_campaign(whole, console)
        if (missing > 0) call console%warn(integer_text(missing)//' of '// &
                                              integer_text(whole%runs*size(whole%entries))// &
                                              ' estimates are missing, or were refused: '//trim(left_out(parts, whole)))
        call publish_campaign(whole, MERGE_COMMAND, table_file, runs_file, console, error)
    end subroutine run_merge

    !> Which shards have runs that no file has, with blanks behind it. They can be named when all files are of a campaign
    !> in equally many shards.
    function left_out(parts, whole) result(text)
        type(campaign_t), intent(in) :: parts(:), whole
        character(MOST_SHOWN*24 + 120) :: text

        logical :: lacks(0:parts(1)%shards - 1)
        integer :: a, i, k, n, run

        text = 'shards are left out'
        n = parts(1)%shards
        if (n < 2 .or. any(parts%shards /= n)) return
        lacks = .false.
        do i = 1, size(whole%cases)
            do a = 1, size(whole%algorithms)
                do run = 1, whole%runs
                    if (all(whole%entries(a, i)%run /= run)) lacks(mod(run - 1, n)) = .true.
                end do
            end do
        end do
        text = 'run again shard'
        do k = 1, n
            if (.not. lacks(k - 1) .or. count(lacks(:k - 1)) > MOST_SHOWN) cycle
            text = trim(text)//trim(merge(',', ' ', count(lacks(:k - 1)) > 1))//' '//integer_text(k)//'/'//integer_text(n)
        end do
        if (count(lacks) > MOST_SHOWN) text = trim(text)//' and '//integer_text(count(lacks) - MOST_SHOWN)//' more'
    end function left_out
end module gracecg_cli_montecarlo
