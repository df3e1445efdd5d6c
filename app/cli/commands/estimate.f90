!> gracecg estimate: the CG offset from an observation set.
module gracecg_cli_estimate
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_environment_sun, only: edge_of_shadow
    use gracecg_environment_time, only: julian_centuries_tt
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t, has_orbit
    use gracecg_estimation_action, only: DO_NOT_USE
    use gracecg_estimation_arc_chain, only: USUAL_ARC, SHORTEST_ARC
    use gracecg_estimation_estimators, only: estimate_offset
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_joint_estimate, only: joint_options_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_plausibility, only: longest_arc
    use gracecg_estimation_solution, only: solution_t, running_estimate_t
    use gracecg_cli_console, only: STATUS_NOT_TO_BE_USED
    use gracecg_cli_estimate_results, only: asked_estimate_t, judged_t, judge_estimate, show_estimate, show_iterations, &
        publish_estimate, publish_refusal, write_estimate_page
    use gracecg_cli_joint, only: declare_joint_options, read_joint_options, find_options, read_observed, run_joint, run_chain
    use gracecg_cli_page_program, only: page_folder
    use gracecg_cli_work
    implicit none
    private
    public :: declare_estimate, run_estimate

    integer, parameter :: MOST_RUNS = 1000
    character(*), parameter :: RUNNING_COLUMNS = &
        'time_s,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm,edited_accelerometer,edited_star_camera'
    real(dp), parameter :: MOST_SECONDS = 1e4_dp        !! Of --arc

    !> What the user asks for.
    type :: request_t
        type(asked_estimate_t) :: asked         !! Folder, algorithm, file of options
        character(:), allocatable :: page, running_file     !! Empty: none
        real(dp) :: arc = 0                     !! Longest arc of a chain, s; 0: as usual
        integer :: threads = 1
        logical :: verbose = .false.
        type(joint_options_t) :: joint          !! Of several runs or arcs
    end type request_t

contains

    !> Arguments and help of `gracecg estimate`.
    subroutine declare_estimate(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('estimate', 'RUN ...', 1, MOST_RUNS, &
                                'Estimates the offset of the centre of gravity, from the '// &
                                'centre of mass to the proof-mass centre in body axes, from '// &
                                'the observation set in the folder RUN. First stands what to do, and why: trim, '// &
                                'leave, calibrate again, or do not use. The exit status is 1 when the '// &
                                'estimate does not converge, and 3 when what to do is: do not use. Of several runs, one '// &
                                'offset with --algorithm optimal, and whether they agree.', &
                                'gracecg simulate front-1 --out run1'//new_line('a')// &
                                'gracecg estimate run1 --algorithm assest-fde --report run1.html')
        call add_study_options(arguments, '--algorithm')
        call arguments%add_option('--options', 'FILE', 'namelist file that says how to estimate: weights, first '// &
                                  'guesses, what else to estimate (if not given: options.nml of RUN, if there is '// &
                                  'one; `default`: those of the setup, or none)')
        call add_format_option(arguments)
        call arguments%add_option('--verbose', '', 'prints each iteration: corrections, state, RMS of the residuals')
        call arguments%add_option('--report', 'FILE.html', 'writes a page on this calibration: errors, what '// &
                                  'they come from, residuals, verdict (takes Python); its numbers and figures go '// &
                                  'into the folder FILE_files')
        call arguments%add_option('--running', 'FILE', 'CSV of the estimate as it grows with the samples; '// &
                                  'sequential alone has one')
        call declare_joint_options(arguments)
        call arguments%add_option('--arc', 'S', 'optimal estimates a run that is too long for one fit in arcs of so many '// &
                                  'seconds at most (default '//rounded_text(USUAL_ARC, 3)//'), and joins them; given, also '// &
                                  'a shorter run')
        call add_study_options(arguments, '--threads')
    end subroutine declare_estimate

    !> The work of `gracecg estimate`.
    subroutine run_estimate(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(request_t) :: request
        type(observation_set_t) :: observations
        type(estimation_options_t) :: options
        logical :: chained

        call read_request(arguments, request, misuse)
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return
        if (arguments%positional_count() > 1) then
            call run_joint(arguments, request%joint, console, error)
            return
        end if
        call check_writable(request%page, error)
        if (.not. allocated(error)) call check_writable(request%running_file, error)
        if (allocated(error)) return
        call find_options(request%asked%folder, request%asked%options_file, console)
        call read_observed(request%asked%folder, request%asked%options_file, observations, options, error)
        chained = .false.
        if (.not. allocated(error) .and. request%asked%algorithm == 'optimal') &
            chained = observations%knowledge%duration > merge(request%arc, longest_arc(observations%knowledge), request%arc > 0)
        if (.not. allocated(error)) call refuse_of_arcs(arguments, observations%knowledge, chained, error)
        if (chained .and. .not. allocated(error)) then
            call run_chain(observations, options, request%joint, merge(request%arc, USUAL_ARC, request%arc > 0), &
                           request%threads, console, error)
        else
            call run_one(request, observations, options, console, error)
        end if
    end subroutine run_estimate

    !> What is asked for. Misuse: options that one, or several runs, or an algorithm do not have.
    subroutine read_request(arguments, request, misuse)
        type(arguments_t), intent(in) :: arguments
        type(request_t), intent(out) :: request
        type(error_t), allocatable, intent(inout) :: misuse

        integer :: runs

        runs = arguments%positional_count()
        request%asked%folder = arguments%positional(1)
        request%verbose = arguments%has('--verbose')
        call arguments%get('--algorithm', request%asked%algorithm, misuse)
        call arguments%get('--options', request%asked%options_file, misuse)
        call arguments%get('--report', request%page, misuse)
        call arguments%get('--running', request%running_file, misuse)
        call arguments%get('--arc', request%arc, misuse, low=SHORTEST_ARC, high=MOST_SECONDS)
        call arguments%get_threads(request%threads, misuse)
        call read_joint_options(arguments, request%joint, misuse)
        associate (algorithm => request%asked%algorithm)
            call refuse_if(request%running_file /= '' .and. algorithm /= 'sequential', '--running: '//algorithm// &
                           ' estimates from all samples at once and has no running estimate; use --algorithm sequential', misuse)
            call refuse_if(runs == 1 .and. arguments%has('--changes'), '--changes is for several runs', misuse)
            call refuse_if(arguments%has('--arc') .and. (algorithm /= 'optimal' .or. runs > 1), &
                           '--arc is for one run and --algorithm optimal: several runs are joined as they are', misuse)
            call refuse_if(runs > 1 .and. (algorithm /= 'optimal' .or. request%page /= ''), &
                           'several runs are estimated with --algorithm optimal, without --report', misuse)
        end associate
    end subroutine read_request

    !> A chain has a fit for each arc: what shows one fit is refused; and of one fit, what only a chain has.
    subroutine refuse_of_arcs(arguments, knowledge, chained, error)
        type(arguments_t), intent(in) :: arguments
        type(operator_knowledge_t), intent(in) :: knowledge
        logical, intent(in) :: chained      !! The run is estimated in arcs
        type(error_t), allocatable, intent(out) :: error

        character(9), parameter :: OF_ONE(2) = [character(9) :: '--report', '--verbose'], OF_MANY(2) = [character(9) :: '--own', &
                                                                                                        '--also']
        integer :: i

        do i = 1, 2
            call refuse_if(chained .and. arguments%has(trim(OF_ONE(i))), trim(OF_ONE(i))//' shows one fit, but the run of '// &
                           rounded_text(knowledge%duration, 6)//' s is estimated in arcs, each with a fit of its own: leave '// &
                           'it out; --format csv or json has the arcs', error)
            call refuse_if(.not. chained .and. arguments%has(trim(OF_MANY(i))), trim(OF_MANY(i))//' is for several runs, or '// &
                           'for one in several arcs (--arc)', error)
        end do
    end subroutine refuse_of_arcs

    !> The estimate of one run in one fit. Also one that fails, or could not begin, has its page.
    subroutine run_one(request, observations, options, console, error)
        type(request_t), intent(in) :: request
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(inout) :: options
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(inout) :: error      !! Allocated where there is nothing to estimate

        type(solution_t) :: solution
        type(fit_record_t) :: record
        type(judged_t) :: judged
        logical :: begun

        begun = .not. allocated(error)
        options%history = request%verbose
        if (begun) call estimate_offset(request%asked%algorithm, observations, options, solution, error, record=record)
        if (begun .and. allocated(error)) then
            call warn_of_shadow(observations, console)
            call publish_refusal(request%asked, observations, solution, record, console, error%message)
        end if
        if (.not. allocated(error)) then
            if (request%running_file /= '') call write_running_estimate(request%running_file, solution%running, error)
            if (allocated(error)) return
            call judge_estimate(observations, solution, record, judged, error)
            if (allocated(error)) return
            if (judged%verdict%action%kind == DO_NOT_USE) then
                console%status_done = STATUS_NOT_TO_BE_USED
                call warn_of_shadow(observations, console)
            end if
            call show_estimate(observations%knowledge, solution, judged, console)
            call warn(observations%knowledge, solution, judged%verdict%action%text, console)
            if (allocated(solution%history)) call show_iterations(solution, console)
            call publish_estimate(request%asked, observations, solution, record, judged, console, error)
            if (allocated(error)) return
            if (.not. solution%converged) &
                call fail(error, request%asked%algorithm//' did not converge in '//integer_text(solution%iterations)// &
                          ' iterations: the offset is not to be relied upon; check the star-camera '// &
                          'samples, or give guess_quaternion and guess_angular_velocity with --options')
        end if
        if (request%page /= '') call write_page(request, observations, solution, record, judged, console, error)
    end subroutine run_one

    !> Of samples that cannot be used, where the satellite passes the edge of the Earth's shadow.
    subroutine warn_of_shadow(observations, console)
        type(observation_set_t), intent(in) :: observations
        type(console_t), intent(inout) :: console

        real(dp) :: edge

        if (.not. has_orbit(observations)) return
        associate (o => observations, duration => observations%knowledge%duration)
            edge = edge_of_shadow(julian_centuries_tt(o%knowledge%epoch), o%orbit_time, o%orbit_position, duration)
            if (edge < 0) return
            call console%warn('the satellite passes the edge of the Earth''s shadow at '//rounded_text(edge, 3)//' s, where '// &
                              'the forces change: optimal estimates that; for the other algorithms take another '// &
                              'time, or a part of the samples without it (duration and epoch of setup.nml)')
        end associate
    end subroutine warn_of_shadow

    !> Writes the page, also of an estimate that is refused: then the refusal stays the command's error.
    subroutine write_page(request, observations, solution, record, judged, console, error)
        type(request_t), intent(in) :: request
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record
        type(judged_t), intent(inout) :: judged                 !! Of an estimate that is refused it is made here
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(inout) :: error      !! Says why the estimate is refused

        type(error_t), allocatable :: failure

        if (.not. allocated(error)) then
            call write_estimate_page(request%page, request%asked, observations, solution, record, judged, console, error)
            if (.not. allocated(error)) &
                call console%line('written: '//request%page//'; its numbers and figures: '//page_folder(request%page))
            return
        end if
        call judge_estimate(observations, solution, record, judged, failure, error%message)
        call write_estimate_page(request%page, request%asked, observations, solution, record, judged, console, failure, &
                                 error%message)
        if (allocated(failure)) then
            call console%warn('no page: '//failure%message)
        else
            call console%message('written: '//request%page//', the page of a refused estimate')
        end if
    end subroutine write_page

    !> What the estimator had to bridge, and what the formal errors leave out.
    subroutine warn(knowledge, solution, said, console)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(solution_t), intent(in) :: solution
        character(*), intent(in) :: said        !! The action
        type(console_t), intent(inout) :: console

        call console%warn_all(solution%warnings, said)
        if (all(solution%noise_level > 0)) return       ! what is not given has been estimated
        if (.not. all(knowledge%accelerometer_noise%level > 0)) &
            call console%warn('the setup gives no noise_level of the accelerometer '// &
                                 'for some axis: the sigmas leave it out')
        if (.not. all(knowledge%star_camera_sigma > 0)) &
            call console%warn('the setup gives no noise_about_axes of the star '// &
                                 'camera for some axis: the sigmas leave it out')
    end subroutine warn

    !> Writes a row an epoch. Fails when the file cannot be written, and then leaves none half-written.
    subroutine write_running_estimate(path, running, error)
        character(*), intent(in) :: path    !! Of the CSV file
        type(running_estimate_t), intent(in) :: running
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        integer :: k

        call file%open(path, RUNNING_COLUMNS, [character(1) ::], error)
        if (allocated(error)) return
        do k = lbound(running%time, 1), ubound(running%time, 1)
            call file%row([running%time(k), running%offset(:, k)/MILLIMETRE, running%sigma(:, k)/MILLIMETRE, &
                           real(running%edited_accelerometer(k), dp), real(running%edited_star_camera(k), dp)])
        end do
        call file%commit(error)
    end subroutine write_running_estimate
end module gracecg_cli_estimate
