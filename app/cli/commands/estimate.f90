!> gracecg estimate: the CG offset from an observation set.
module gracecg_cli_estimate
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: string_t, integer_text, rounded_text
    use gracecg_spacecraft_torque_rods, only: check_rods_fire
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_observation_files, only: read_observations, OBSERVATION_FILES, SETUP_FILE
    use gracecg_estimation_arc_chain, only: USUAL_ARC, SHORTEST_ARC
    use gracecg_estimation_arc_length, only: longest_arc
    use gracecg_estimation_joint_estimate, only: joint_options_t
    use gracecg_estimation_options, only: estimation_options_t, read_options, OF_SETUP
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_plausibility, only: refuse_implausible
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_files_file, only: check_writable
    use gracecg_estimation_estimators, only: estimate_offset, ESTIMATOR_NAMES
    use gracecg_cli_arc_chain, only: run_chain
    use gracecg_cli_joint, only: declare_joint_options, joint_option_given, run_joint, take_groups
    use gracecg_cli_running_file, only: write_running_estimate
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_console, only: console_t
    use gracecg_cli_estimate_results, only: asked_estimate_t, show_estimate, show_iterations, publish_estimate, &
        write_estimate_page
    use gracecg_cli_page_program, only: page_folder
    use gracecg_cli_results, only: add_format_option, take_format
    implicit none
    private
    public :: declare_estimate, run_estimate

    integer, parameter :: MOST_RUNS = 1000

contains

    !> Arguments and help of `gracecg estimate`.
    subroutine declare_estimate(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('estimate', 'RUN ...', 1, MOST_RUNS, &
                                'Estimates the offset of the centre of gravity, from the '// &
                                'centre of mass to the proof-mass centre in body axes, from '// &
                                'the observation set in the folder RUN. The exit status is 1 when the '// &
                                'estimate does not converge. Of several runs, folders or estimates '// &
                                'saved with --format json, one offset with --algorithm optimal, and '// &
                                'whether they agree.', &
                                'gracecg simulate front-1 --out run1'//new_line('a')// &
                                'gracecg estimate run1 --algorithm assest-fde --report run1.html')
        call arguments%add_option('--algorithm', 'NAME', algorithm_help(), required=.true., choices=ESTIMATOR_NAMES)
        call arguments%add_option('--options', 'FILE', 'namelist file that says how to estimate: weights, first '// &
                                  'guesses, what else to estimate (default: what the algorithm needs no telling)')
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
        call arguments%add_option('--threads', 'N', 'to work on arcs (default: the processors of the machine)')
    end subroutine declare_estimate

    function algorithm_help() result(text)
        character(:), allocatable :: text

        integer :: i

        text = 'one of:'
        do i = 1, size(ESTIMATOR_NAMES)
            text = text//' '//trim(ESTIMATOR_NAMES(i))
        end do
    end function algorithm_help

    !> The work of `gracecg estimate`.
    subroutine run_estimate(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(fit_record_t) :: record
        type(estimation_options_t) :: options
        type(joint_options_t) :: joint
        type(asked_estimate_t) :: asked
        character(:), allocatable :: algorithm, page, running_file, options_file
        real(dp) :: arc
        integer :: threads

        call arguments%get('--algorithm', algorithm, misuse, choices=ESTIMATOR_NAMES)
        call take_format(arguments, console, misuse)
        call arguments%get('--report', page, misuse, default='')
        call arguments%get('--running', running_file, misuse, default='')
        call arguments%get('--options', options_file, misuse, default='')
        call refuse_if(running_file /= '' .and. algorithm /= 'sequential', '--running: '//algorithm// &
                       ' estimates from all samples at once and has no running estimate; use --algorithm '// &
                       'sequential', misuse)
        call arguments%get('--arc', arc, misuse, default=0.0_dp, low=SHORTEST_ARC, high=1e4_dp)
        call arguments%get_threads(threads, misuse)
        call take_groups(arguments, '--own', joint%own, misuse)
        call take_groups(arguments, '--also', joint%added, misuse)
        call refuse_if(arguments%positional_count() == 1 .and. arguments%has('--changes'), &
                       '--changes is for several runs', misuse)
        call refuse_if(arguments%has('--arc') .and. (algorithm /= 'optimal' .or. arguments%positional_count() > 1), &
                       '--arc is for one run and --algorithm optimal: several runs are joined as they are', misuse)
        call refuse_if(arguments%positional_count() > 1 .and. (algorithm /= 'optimal' .or. page /= ''), &
                       'several runs are estimated with --algorithm optimal, without --report', misuse)
        if (allocated(misuse)) return
        if (arguments%positional_count() > 1) then
            call run_joint(arguments, options_file, console, misuse, error)
            return
        end if

        asked = asked_estimate_t(arguments%positional(1), algorithm, options_file)
        call check_writable(page, error)
        if (.not. allocated(error)) call check_writable(running_file, error)
        if (allocated(error)) return
        call read_run(arguments%positional(1), options_file, observations, options, console, error)
        if (.not. allocated(error) .and. algorithm == 'optimal' .and. &
            observations%knowledge%duration > merge(arc, longest_arc(observations%knowledge), arc > 0)) then
            call refuse_of_chain(observations%knowledge, page /= '', arguments%has('--verbose'), error)
            if (.not. allocated(error)) &
                call run_chain(observations, options, joint, merge(arc, USUAL_ARC, arc > 0), threads, console, error)
            return
        end if
        if (.not. allocated(error) .and. joint_option_given(arguments) /= '') then
            call fail(error, trim(joint_option_given(arguments))//' is for several runs, or for one in several arcs (--arc)')
            return
        end if
        if (.not. allocated(error)) &
            call estimate(algorithm, page /= '' .or. console%format == 'json', arguments%has('--verbose'), observations, &
                          options, solution, record, error)
        if (allocated(error)) then
            if (page /= '') call show_page(error%message)
            return
        end if
        if (running_file /= '') call write_running_estimate(running_file, solution%running, error)
        if (allocated(error)) return
        call warn(observations%knowledge, solution, console)
        if (allocated(solution%history)) call show_iterations(solution, console)
        call show_estimate(observations%knowledge, solution, console)
        call publish_estimate(asked, observations, solution, record, console, error)
        if (allocated(error)) return
        if (solution%converged) then
            if (page /= '') call show_page('')
            return
        end if
        call fail(error, algorithm//' did not converge in '//integer_text(solution%iterations)// &
                  ' iterations: the offset is not to be relied upon; check the star-camera '// &
                  'samples, or give guess_quaternion and guess_angular_velocity with --options')
        if (page /= '') call show_page(error%message)

    contains

        !> Writes the page, also of an estimate that is refused: then the refusal stays the command's error.
        subroutine show_page(refusal)
            character(*), intent(in) :: refusal     !! Why, or nothing

            type(error_t), allocatable :: failure

            if (refusal == '') then
                call write_estimate_page(page, asked, observations, solution, record, console, error)
                if (.not. allocated(error)) &
                    call console%line('written: '//page//'; its numbers and figures: '//page_folder(page))
            else
                call write_estimate_page(page, asked, observations, solution, record, console, failure, refusal)
                if (allocated(failure)) then
                    call console%warn('no page: '//failure%message)
                else
                    call console%message('written: '//page//', the page of a refused estimate')
                end if
            end if
        end subroutine show_page
    end subroutine run_estimate

    !> The observations of a folder, and how to estimate.
    subroutine read_run(folder, options_file, observations, options, console, error)
        character(*), intent(in) :: folder, options_file
        type(observation_set_t), intent(out) :: observations
        type(estimation_options_t), intent(out) :: options
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: nothing

        call read_observations(folder, observations, error)
        if (allocated(error)) then
            observations = nothing      ! not the part that was read
            return
        end if
        call check_rods_fire(observations%knowledge%rods, observations%knowledge%duration, error)
        if (.not. allocated(error)) call take_options(folder, options_file, options, console, error)
    end subroutine read_run

    !> What the algorithm makes of the observations.
    subroutine estimate(algorithm, recorded, verbose, observations, options, solution, record, error)
        character(*), intent(in) :: algorithm
        logical, intent(in) :: recorded         !! The fit is to be recorded, for JSON or a page
        logical, intent(in) :: verbose          !! Every iteration is to be kept
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(inout) :: options
        type(solution_t), intent(out) :: solution
        type(fit_record_t), intent(out) :: record
        type(error_t), allocatable, intent(out) :: error

        options%history = verbose
        options%information = recorded
        if (recorded) then
            call estimate_offset(algorithm, observations, options, solution, error, record=record)
        else
            call estimate_offset(algorithm, observations, options, solution, error)
        end if
        if (.not. allocated(error)) call refuse_implausible(solution, options%largest_offset, error)
    end subroutine estimate

    !> A chain has a fit for each arc: what shows one fit is refused.
    subroutine refuse_of_chain(knowledge, page, verbose, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        logical, intent(in) :: page, verbose        !! --report, --verbose
        type(error_t), allocatable, intent(out) :: error

        if (.not. (page .or. verbose)) return
        call fail(error, trim(merge('--report ', '--verbose', page))//' shows one fit, but the run of '// &
                  rounded_text(knowledge%duration, 6)//' s is estimated in arcs, each with a fit of its own: leave it out; '// &
                  '--format csv or json has the arcs')
    end subroutine refuse_of_chain

    !> The options of --options; without it those that need no telling, or those in a setup.nml of version 0.1.
    subroutine take_options(folder, options_file, options, console, error)
        character(*), intent(in) :: folder, options_file
        type(estimation_options_t), intent(out) :: options
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(estimation_options_t) :: former
        type(string_t), allocatable :: warning

        call read_options(folder//'/'//trim(OBSERVATION_FILES(SETUP_FILE)), former, error, OF_SETUP, warning)
        if (allocated(error)) return
        if (allocated(warning)) call console%warn(warning%text)
        options = former
        if (options_file /= '') call read_options(options_file, options, error)
    end subroutine take_options

    !> What the estimator had to bridge, and what the formal errors leave out.
    subroutine warn(knowledge, solution, console)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(solution_t), intent(in) :: solution
        type(console_t), intent(inout) :: console

        integer :: i

        do i = 1, size(solution%warnings)
            call console%warn(solution%warnings(i)%text)
        end do
        if (all(solution%noise_level > 0)) return       ! what is not given has been estimated
        if (.not. all(knowledge%accelerometer_noise%level > 0)) &
            call console%warn('the setup gives no noise_level of the accelerometer '// &
                                 'for some axis: the sigmas leave it out')
        if (.not. all(knowledge%star_camera_sigma > 0)) &
            call console%warn('the setup gives no noise_about_axes of the star '// &
                                 'camera for some axis: the sigmas leave it out')
    end subroutine warn
end module gracecg_cli_estimate
