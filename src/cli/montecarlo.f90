!> gracecg montecarlo: Tables 6.1 and 6.2 of CSR-TM-00-01, ours beside the published values and the
!> theoretical prediction.
module gracecg_cli_montecarlo
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_text, only: string_t, integer_text, join, padded, parse_integer, split
    use gracecg_files_file, only: check_writable
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_estimators, only: estimate_offset, ESTIMATOR_NAMES, REPORT_ESTIMATORS
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_simulation_case_library, only: expanded_cases
    use gracecg_simulation_simulator, only: simulator_t, observe
    use gracecg_simulation_switches, only: error_switches_t, new_switched_simulator, switch_off, SOURCE_NAMES
    use gracecg_studies_campaign, only: campaign_t, new_campaign, run_case
    use gracecg_studies_campaign_files, only: write_table, write_runs
    use gracecg_cli_campaign_tables, only: show_campaign, read_campaign_files, wide, REPORT_RUNS
    use gracecg_cli_calibration_argument, only: add_options_option, take_firing_calibration
    use gracecg_cli_arguments, only: arguments_t, refuse_if, MOST_RUNS
    use gracecg_cli_console, only: console_t
    implicit none
    private
    public :: declare_montecarlo, run_montecarlo

    character(*), parameter :: COMMAND = 'montecarlo'

    !> What the user asks for.
    type :: request_t
        type(string_t), allocatable :: cases(:), algorithms(:)
        integer :: runs = REPORT_RUNS, seed = 1, threads = 1
        integer :: shard = 1, shards = 1
        type(error_switches_t) :: switches
        character(:), allocatable :: without    !! Error sources that are switched off, as given; empty: none
        character(:), allocatable :: table_file, runs_file      !! Empty: none
    end type request_t

contains

    !> Arguments and help of `gracecg montecarlo`.
    subroutine declare_montecarlo(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe(COMMAND, '', 0, 0, &
                                'Simulates and estimates many calibrations of each case and prints the RMS '// &
                                'error of the CG offset in the layout of Tables 6.1 and 6.2 of '// &
                                'CSR-TM-00-01, beside the published values and the prediction of a '// &
                                'covariance analysis. A large campaign can be done in shards, on as many '// &
                                'machines as there are, and put together by gracecg merge.', &
                                'gracecg montecarlo --cases front-3,back-3 --algorithms assest-fde --runs 100')
        call arguments%add_option('--cases', 'LIST', 'names or namelist files, separated by commas; printed: '// &
                                  'the six with the input cards as printed (default: the six built-in cases)')
        call arguments%add_option('--algorithms', 'LIST', 'of '//join(ESTIMATOR_NAMES, ', ')// &
                                  ' (default: those of the report, '//join(REPORT_ESTIMATORS, ', ')//')')
        call arguments%add_option('--runs', 'N', 'of each case (default 15, as in the report)')
        call arguments%add_option('--shard', 'K/N', 'do only every N-th run, from run K on; --runs stays that '// &
                                  'of the whole campaign')
        call arguments%add_option('--without', 'LIST', 'error sources to switch off in the simulation, of '// &
                                  join(SOURCE_NAMES, ', ')//' (the three others that are no noise)')
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--threads', 'N', 'to work on (default: the processors of the machine); '// &
                                  'the numbers do not depend on it')
        call arguments%add_option('--out', 'FILE', 'CSV file for the statistics')
        call arguments%add_option('--runs-out', 'FILE', 'CSV file for the estimate of every run')
        call add_options_option(arguments)
    end subroutine declare_montecarlo

    !> The work of `gracecg montecarlo`.
    subroutine run_montecarlo(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(request_t) :: request
        type(campaign_t) :: campaign
        integer :: i

        call read_request(arguments, request, misuse)
        if (allocated(misuse)) return
        call check_writable(request%table_file, error)
        if (.not. allocated(error)) call check_writable(request%runs_file, error)
        if (allocated(error)) return
        campaign = new_campaign(padded(request%algorithms), size(request%cases), request%seed, request%runs, &
                                request%shard, request%shards)
        do i = 1, size(request%cases)
            call do_case(arguments, request, i, campaign, console, error)
            if (allocated(error)) return
        end do
        call console%line('(* expected by theory: noise, systematic errors and drag that is not a straight line)')
        if (request%without /= '') call console%line('(error sources switched off here: '//request%without// &
                                                    '; the report''s values have them all)')
        call console%line('')
        call show_campaign(campaign, console)
        if (request%table_file /= '') call write_table(request%table_file, campaign, COMMAND, error)
        if (allocated(error)) return
        if (request%runs_file /= '') call write_runs(request%runs_file, campaign, COMMAND, error)
    end subroutine run_montecarlo

    subroutine read_request(arguments, request, misuse)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(out) :: request
        type(error_t), allocatable, intent(out) :: misuse

        type(string_t), allocatable :: names(:)

        call arguments%get('--cases', names, misuse, default=join(REPORT_CASE_NAMES, ','))
        if (.not. allocated(misuse)) call expanded_cases(names, request%cases)
        call arguments%get('--algorithms', request%algorithms, misuse, default=join(REPORT_ESTIMATORS, ','), &
                           choices=ESTIMATOR_NAMES)
        call arguments%get('--runs', request%runs, misuse, default=REPORT_RUNS, low=1, high=MOST_RUNS)
        call read_shard(arguments, request, misuse)
        call read_switches(arguments, request, misuse)
        call arguments%get('--seed', request%seed, misuse, default=1)
        call arguments%get_threads(request%threads, misuse)
        call read_campaign_files(arguments, request%table_file, request%runs_file, misuse)
    end subroutine read_request

    subroutine read_switches(arguments, request, misuse)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(inout) :: request
        type(error_t), allocatable, intent(inout) :: misuse

        type(string_t), allocatable :: names(:)
        integer :: i

        call arguments%get('--without', request%without, misuse, default='')
        if (request%without == '') return
        names = split(request%without, ',')
        do i = 1, size(names)
            if (allocated(misuse)) return
            call switch_off(request%switches, names(i)%text, misuse)
            call add_context(misuse, 'option --without')
        end do
    end subroutine read_switches

    subroutine read_shard(arguments, request, misuse)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(inout) :: request
        type(error_t), allocatable, intent(inout) :: misuse

        character(:), allocatable :: text
        integer :: slash
        logical :: ok(2)

        call arguments%get('--shard', text, misuse, default='1/1')
        slash = index(text, '/')
        call parse_integer(text(:slash - 1), request%shard, ok(1))
        call parse_integer(text(slash + 1:), request%shards, ok(2))
        call refuse_if(slash == 0 .or. .not. all(ok) .or. request%shard < 1 .or. request%shard > request%shards, &
                       'option --shard: "'//text//'" is not K/N with whole numbers, K from 1 to N', misuse)
        call refuse_if(request%shard > request%runs, &
                       'option --shard: shard '//text//' of '//integer_text(request%runs)// &
                       ' runs has none; there are as many shards as runs at most', misuse)
    end subroutine read_shard

    !> Simulates case number i, with all algorithms.
    subroutine do_case(arguments, request, i, campaign, console, error)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(in) :: request
        integer, intent(in) :: i
        type(campaign_t), intent(inout) :: campaign
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: calibration
        type(simulator_t) :: simulator

        call take_firing_calibration(arguments, request%cases(i)%text, console, calibration, error)
        if (.not. allocated(error)) call new_switched_simulator(calibration%case, request%switches, simulator, error)
        if (allocated(error)) return
        calibration%case = simulator%case
        call run_case(campaign, i, calibration, simulator, request%threads, error, console)
        if (allocated(error)) return
        if (i == 1) call show_heading(request, console)
        call show_one_calibration(simulator, calibration%options, request, campaign%entries(1, i)%predicted, &
                                  console, error)
    end subroutine do_case

    subroutine show_heading(request, console)
        type(request_t), intent(in) :: request
        type(console_t), intent(inout) :: console

        call console%line('CG offset d (centre of mass to proof mass, body axes, mm) of one simulated '// &
                          'calibration: '//request%algorithms(1)%text//', run 1, seed '//integer_text(request%seed))
        call console%line('case          d_x true  estimate  error*    d_y true  estimate  error*    '// &
                          'd_z true  estimate  error*')
    end subroutine show_heading

    !> The first run of a case, as an operator would see it.
    subroutine show_one_calibration(simulator, options, request, predicted, console, error)
        type(simulator_t), intent(in) :: simulator
        type(estimation_options_t), intent(in) :: options
        type(request_t), intent(in) :: request
        real(dp), intent(in) :: predicted(3)        !! RMS error by theory, mm
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        type(estimation_options_t) :: own
        type(solution_t) :: solution
        character(120) :: row
        integer :: i

        call observe(simulator, request%seed, 1, observations, error)
        if (allocated(error)) return
        own = options
        own%covariance = .false.
        call estimate_offset(request%algorithms(1)%text, observations, own, solution, error)
        if (allocated(error)) return
        write (row, '(3(f10.4, f10.4, f8.4, :, 2x))') &
            (simulator%case%satellite%offset(i)/MILLIMETRE, solution%offset(i)/MILLIMETRE, &
             predicted(i), i=1, 3)
        call console%line(wide(trim(simulator%case%name), 12)//trim(row))
    end subroutine show_one_calibration
end module gracecg_cli_montecarlo
