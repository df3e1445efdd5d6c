!> gracecg estimate of several calibrations, or of one long run in arcs: one offset.
module gracecg_cli_joint
    use gracecg_base_constants, only: SECONDS_PER_DAY
    use gracecg_environment_time, only: utc_t, seconds_between
    use gracecg_files_file, only: file_exists
    use gracecg_spacecraft_torque_rods, only: check_rods_fire
    use gracecg_observations_observation_files, only: read_observations, OBSERVATION_FILES, SETUP_FILE
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_arc_chain, only: arc_chain_t, estimate_chain
    use gracecg_estimation_action, only: action_t, DO_NOT_USE
    use gracecg_estimation_joint_action, only: act_on_runs, say_disagreement
    use gracecg_estimation_joint_estimate, only: joint_options_t, joint_solution_t, joint_sigma, FAMILY_LEVEL
    use gracecg_estimation_joint_runs, only: joint_run_t, run_from_observations, estimate_runs
    use gracecg_estimation_offset_change, only: read_changes
    use gracecg_estimation_options, only: estimation_options_t, read_options, OPTIONS_FILE
    use gracecg_observations_parameters, only: parameter_names, PARAMETER_UNITS
    use gracecg_estimation_run_information, only: SHARED_GROUPS, JOINED
    use gracecg_cli_calibration_json, only: put_action
    use gracecg_cli_console, only: STATUS_NOT_TO_BE_USED
    use gracecg_cli_work
    implicit none
    private
    public :: declare_joint_options, read_joint_options, find_options, read_observed, run_joint, run_chain, show_offset

contains

    !> The options of `gracecg estimate` that belong to several runs.
    subroutine declare_joint_options(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%add_option('--own', 'LIST', 'of several runs: what each has its own instead of one for all: '// &
                                  join(SHARED_GROUPS, ', '), choices=SHARED_GROUPS)
        call arguments%add_option('--also', 'LIST', 'of several runs: what of these is estimated though optimal does '// &
                                  'not by itself, with its a-priori knowledge', choices=SHARED_GROUPS)
        call arguments%add_option('--changes', 'FILE', 'of several runs: CSV of masses moved between them, time_utc, '// &
                                  'change of the offset and its sigmas in mm')
    end subroutine declare_joint_options

    !> What they say, but for the changes.
    subroutine read_joint_options(arguments, options, misuse)
        type(arguments_t), intent(in) :: arguments
        type(joint_options_t), intent(out) :: options
        type(error_t), allocatable, intent(inout) :: misuse

        type(string_t), allocatable :: own(:), also(:)
        integer :: i

        call arguments%get('--own', own, misuse)
        call arguments%get('--also', also, misuse)
        options%own = [(any(padded(own) == SHARED_GROUPS(i)), i=1, size(SHARED_GROUPS))]
        options%added = [(any(padded(also) == SHARED_GROUPS(i)), i=1, size(SHARED_GROUPS))]
    end subroutine read_joint_options

    !> The joint estimate of all runs named.
    subroutine run_joint(arguments, options, console, error)
        type(arguments_t), intent(in) :: arguments
        type(joint_options_t), intent(inout) :: options     !! The changes are read into it
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: LONG = 14*SECONDS_PER_DAY    ! Chosen: gas and trims hardly move d
        type(joint_run_t), allocatable :: runs(:)
        type(observation_set_t) :: observations
        type(estimation_options_t) :: run_options
        type(joint_solution_t) :: solution
        type(action_t) :: action
        type(string_t), allocatable :: names(:)
        character(:), allocatable :: changes, options_file, own_file
        real(dp) :: apart       ! s
        integer :: i, k

        call arguments%get('--options', options_file, error)
        call arguments%get('--changes', changes, error)
        if (changes /= '') call read_changes(changes, options%changes, error)
        if (allocated(error)) return
        names = arguments%words
        allocate (runs(size(names)))
        do i = 1, size(runs)
            own_file = options_file
            call find_options(names(i)%text, own_file, console)
            call read_observed(names(i)%text, own_file, observations, run_options, error)
            if (allocated(error)) return
            call run_from_observations(observations, run_options, runs(i), error)
            call add_context(error, names(i)%text)
            if (allocated(error)) return
            do k = 1, size(runs(i)%solution%warnings)
                call console%warn(names(i)%text//': '//runs(i)%solution%warnings(k)%text)
            end do
        end do
        apart = maxval([(abs(seconds_between(runs(1)%information%epoch, runs(i)%information%epoch)), i=1, size(runs))])
        if (apart > LONG .and. changes == '') call console%warn('the runs are up to '// &
            trim(rounded_text(apart/SECONDS_PER_DAY, 3))//' days apart, and d is taken as the same: name what changed it in '// &
            '--changes, or join estimates by gracecg history')
        call estimate_runs(runs, options, solution, error)
        if (allocated(error)) return
        call act_on_runs(runs, options, names, solution, action)
        if (action%kind == DO_NOT_USE) console%status_done = STATUS_NOT_TO_BE_USED
        call console%paragraph(action%text)
        call report('runs', 'joint', names, runs%information%epoch, solution, console, error, action)
    end subroutine run_joint

    !> Estimates a run in arcs, and shows them as runs are shown.
    subroutine run_chain(observations, options, joint, length, threads, console, error)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(joint_options_t), intent(in) :: joint
        real(dp), intent(in) :: length      !! Of the arcs, at most, s
        integer, intent(in) :: threads      !! On which arcs are estimated
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(arc_chain_t) :: chain
        type(string_t), allocatable :: names(:)
        character(:), allocatable :: text
        integer :: i

        call estimate_chain(observations, options, joint, length, threads, chain, error, console)
        if (allocated(error)) return
        call console%warn_all(chain%warnings)
        allocate (names(0))
        do i = 1, size(chain%arcs)
            associate (arc => chain%arcs(i))
                if (arc%joined) call append(names, rounded_text(arc%from, 6)//'-'//rounded_text(arc%to, 6)//' s')
            end associate
        end do
        if (.not. chain%solution%consistent) then
            call say_disagreement('arcs', names, pack(chain%arcs%information, chain%arcs%joined), joint, chain%solution, text)
            call console%warn(text)
        end if
        call console%paragraph('no action: what the setup says is not tested in arcs; estimate the part with a manoeuvre by '// &
                               'itself before masses are moved')
        call report('arcs', trim(observations%knowledge%name), names, &
                    pack(chain%arcs%information%epoch, chain%arcs%joined), chain%solution, console, error)
    end subroutine run_chain

    !> The observations of a folder, and how to estimate.
    subroutine read_observed(folder, options_file, observations, options, error)
        character(*), intent(in) :: folder              !! Of the observations
        character(*), intent(in) :: options_file        !! Path; empty: those of the setup
        type(observation_set_t), intent(out) :: observations
        type(estimation_options_t), intent(out) :: options
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: nothing

        call read_observations(folder, observations, error)
        if (allocated(error)) then
            observations = nothing      ! not the part that was read
            return
        end if
        call check_rods_fire(observations%knowledge%rods, observations%knowledge%duration, error)
        if (.not. allocated(error)) &
            call read_options(folder//'/'//trim(OBSERVATION_FILES(SETUP_FILE)), options, error, beside=.true.)
        if (.not. allocated(error) .and. options_file /= '') call read_options(options_file, options, error)
    end subroutine read_observed

    !> The file of options of a run: that which is asked for; if none is, options.nml of its folder, and this is told.
    subroutine find_options(folder, file, console)
        character(*), intent(in) :: folder              !! Of the observations
        character(:), allocatable, intent(inout) :: file
        !! In: of --options, empty if it is not given, or 'default'. Out: path; empty: those of the setup
        type(console_t), intent(inout) :: console

        if (file == 'default') then
            file = ''
        else if (file == '' .and. file_exists(folder//'/'//OPTIONS_FILE)) then
            file = folder//'/'//OPTIONS_FILE
            call console%message('options of '//file)
        end if
    end subroutine find_options

    !> The joint estimate and each run: for people, as CSV or JSON.
    subroutine report(kind, case, names, epochs, solution, console, error, action)
        character(*), intent(in) :: kind            !! What is joined: runs or arcs
        character(*), intent(in) :: case            !! Member of JSON
        type(string_t), intent(in) :: names(:)      !! Of each
        type(utc_t), intent(in) :: epochs(:)        !! Time 0 of each
        type(joint_solution_t), intent(in) :: solution
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error
        type(action_t), intent(in), optional :: action  !! What to do, of runs

        type(results_t) :: results
        type(data_table_t) :: table, shared

        table = runs_table(kind, names, epochs, solution)
        shared = shared_table(solution)
        call console%line(integer_text(size(names))//' '//kind//', one offset at '// &
                          utc_text(epochs(solution%last))//' UTC')
        call show_offset(solution%offset, joint_sigma(solution), console)
        call console%line('')
        call console%line('each '//kind(:3)//' alone, and minus all others')
        call console%table(table)
        call console%line('agreement         chi square '//rounded_text(solution%statistic, 4)//' for '// &
                          integer_text(solution%degrees)//' degrees of freedom, probability '// &
                          rounded_text(solution%probability, 3)//' (refused below '//rounded_text(FAMILY_LEVEL, 2)//')')
        if (shared%row_count() > 0) then
            call console%line('')
            call console%line('what the '//kind//' share')
            call console%table(shared)
        end if
        call results%open('estimate')
        if (present(action)) call put_action(action, results)
        call results%member('case', case)
        call results%member('epoch_utc', utc_text(epochs(solution%last)))
        call results%member('offset_m', solution%offset)
        call results%begin('covariance')
        call results%member('matrix', solution%covariance)
        call results%end()
        call results%member('degrees_of_freedom', solution%degrees)
        call results%member('level', FAMILY_LEVEL)
        call shared%to_json(results, 'shared', units=.false.)
        call results%publish(table, console, error)
    end subroutine report

    !> The joint estimate, then each run alone and its difference from all others.
    function runs_table(kind, names, epochs, solution) result(table)
        character(*), intent(in) :: kind            !! As of report, and so on
        type(string_t), intent(in) :: names(:)
        type(utc_t), intent(in) :: epochs(:)
        type(joint_solution_t), intent(in) :: solution
        type(data_table_t) :: table

        integer :: i

        call table%column('run', 'a', kind(:3))
        call table%column('time_utc')
        call axis_columns(table, 'd', '_mm', 'f10.4', 'd, mm')
        call table%columns_of('sigma_x_mm,sigma_y_mm,sigma_z_mm')
        call axis_columns(table, 'difference_', '_mm', 'f10.4', 'difference, mm')
        call axis_columns(table, 'sigma_difference_', '_mm', 'f9.4', 'its sigma, mm')
        call table%column('chi_square', 'f9.2', 'chi square|of 3')
        call table%columns_of('probability,agrees')
        call table%column('variance_factor', 'f8.3', 'variance|factor')
        call table%add('joint', utc_text(epochs(solution%last)))
        call table%add([solution%offset, joint_sigma(solution)]/MILLIMETRE)
        call table%add_nothing(6)
        call table%add([solution%statistic, solution%probability])
        call table%add(solution%consistent)
        call table%add(sum(solution%runs%squares)/max(1, sum(solution%runs%redundancy)))
        do i = 1, size(names)
            associate (run => solution%runs(i))
                call table%add(names(i)%text, utc_text(epochs(i)))
                call table%add([[run%offset, run%sigma, run%difference, run%difference_sigma]/MILLIMETRE, run%statistic, &
                                run%probability])
                call table%add(run%agrees)
                call table%add(run%squares/max(1, run%redundancy))
            end associate
        end do
    end function runs_table

    !> What the runs share beside the offset.
    function shared_table(solution) result(table)
        type(joint_solution_t), intent(in) :: solution
        type(data_table_t) :: table

        integer :: j

        call table%column('name', 'a', 'parameter')
        call table%column('value', 'es12.4', 'value')
        call table%column('sigma', 'es11.2', 'sigma')
        call table%column('unit', 'a', 'unit')
        do j = 1, size(JOINED)
            if (.not. solution%parameter_sigma(j) > 0) cycle
            call table%add(parameter_names(JOINED(j)), [solution%parameter(j), solution%parameter_sigma(j)])
            call table%add(PARAMETER_UNITS(JOINED(j)))
        end do
    end function shared_table

    !> An offset with its sigma, for people.
    subroutine show_offset(offset, sigma, console)
        real(dp), intent(in) :: offset(3), sigma(3)     !! Body axes, m
        type(console_t), intent(inout) :: console

        character(100) :: line
        integer :: i

        do i = 1, 3
            write (line, '("d", a1, f12.5, " +/-", f9.5, " mm")') AXES(i), [offset(i), sigma(i)]/MILLIMETRE
            call console%line(trim(line))
        end do
    end subroutine show_offset
end module gracecg_cli_joint
