!> gracecg estimate RUN1 RUN2 ...: one offset from several calibrations.
module gracecg_cli_joint
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_text, only: string_t, split, integer_text, rounded_text, join
    use gracecg_environment_time, only: utc_t, utc_text
    use gracecg_files_data_table, only: data_table_t
    use gracecg_files_file, only: directory_exists
    use gracecg_files_value, only: did_you_mean
    use gracecg_observations_observation_files, only: read_observations
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_joint_estimate, only: joint_options_t, joint_solution_t, FAMILY_LEVEL
    use gracecg_estimation_joint_runs, only: joint_run_t, run_from_observations, estimate_runs
    use gracecg_estimation_offset_change, only: read_changes
    use gracecg_estimation_options, only: estimation_options_t, read_options
    use gracecg_estimation_parameters, only: PARAMETER_NAMES, PARAMETER_UNITS, JOINED
    use gracecg_estimation_run_information, only: SHARED_GROUPS, JOINED_COUNT
    use gracecg_estimation_saved_estimate, only: read_information
    use gracecg_cli_arguments, only: arguments_t
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t
    implicit none
    private
    public :: declare_joint_options, run_joint, joint_option_given, take_groups, show_joint, publish_joint

    character(9), parameter :: OPTIONS(3) = [character(9) :: '--own', '--also', '--changes']    !! That only a joint estimate has
    character(*), parameter :: COLUMNS = 'run,time_utc,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm,'// &
        'difference_x_mm,difference_y_mm,difference_z_mm,sigma_difference_x_mm,sigma_difference_y_mm,'// &
        'sigma_difference_z_mm,chi_square,probability,agrees,variance_factor'

contains

    !> The options of `gracecg estimate` that belong to several runs.
    subroutine declare_joint_options(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%add_option('--own', 'LIST', 'of several runs: what each has its own instead of one for all: '// &
                                  join(SHARED_GROUPS, ', '))
        call arguments%add_option('--also', 'LIST', 'of several runs: what of these is estimated though optimal does '// &
                                  'not by itself, with its a-priori knowledge')
        call arguments%add_option('--changes', 'FILE', 'of several runs: CSV of masses moved between them, time_utc, '// &
                                  'change of the offset and its sigmas in mm')
    end subroutine declare_joint_options

    !> The first option that is given and belongs to several runs; blank: none.
    function joint_option_given(arguments) result(name)
        type(arguments_t), intent(in) :: arguments
        character(len(OPTIONS)) :: name

        integer :: i

        name = ''
        do i = size(OPTIONS), 1, -1
            if (arguments%has(trim(OPTIONS(i)))) name = OPTIONS(i)
        end do
    end function joint_option_given

    !> The joint estimate of all runs named.
    subroutine run_joint(arguments, options_file, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: options_file        !! Of --options; blank: none
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(inout) :: misuse
        type(error_t), allocatable, intent(out) :: error

        type(joint_run_t), allocatable :: runs(:)
        type(joint_options_t) :: options
        type(joint_solution_t) :: solution
        type(string_t), allocatable :: names(:)
        character(:), allocatable :: changes
        integer :: i

        call take_groups(arguments, '--own', options%own, misuse)
        call take_groups(arguments, '--also', options%added, misuse)
        call arguments%get('--changes', changes, misuse, default='')
        if (allocated(misuse)) return
        if (changes /= '') call read_changes(changes, options%changes, error)
        if (allocated(error)) return
        allocate (runs(arguments%positional_count()))
        do i = 1, size(runs)
            call read_run(arguments%positional(i), options_file, runs(i), console, error)
            if (allocated(error)) return
        end do
        call estimate_runs(runs, options, solution, error)
        if (allocated(error)) return
        allocate (names(size(runs)))
        do i = 1, size(runs)
            names(i)%text = arguments%positional(i)
        end do
        call show_joint('runs', names, runs%information%epoch, solution, console)
        call publish_joint('joint', names, runs%information%epoch, solution, console, error)
    end subroutine run_joint

    !> A list of groups of parameters.
    subroutine take_groups(arguments, name, chosen, misuse)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: name    !! Of the option
        logical, intent(out) :: chosen(:)       !! (SHARED_GROUPS)
        type(error_t), allocatable, intent(inout) :: misuse

        type(string_t), allocatable :: words(:)
        character(:), allocatable :: list
        integer :: i, k

        chosen = .false.
        call arguments%get(name, list, misuse, default='')
        if (allocated(misuse) .or. list == '') return
        words = split(list, ',')
        do i = 1, size(words)
            k = findloc(SHARED_GROUPS == words(i)%text, .true., 1)
            if (k == 0) then
                call fail(misuse, name//': no "'//words(i)%text//'"; there are '//join(SHARED_GROUPS, ', ')// &
                          did_you_mean(words(i)%text, SHARED_GROUPS))
                return
            end if
            chosen(k) = .true.
        end do
    end subroutine take_groups

    !> A run from a folder of observations, or from a saved estimate.
    subroutine read_run(path, options_file, run, console, error)
        character(*), intent(in) :: path, options_file
        type(joint_run_t), intent(out) :: run
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        type(estimation_options_t) :: options
        integer :: i

        if (.not. directory_exists(path)) then
            call read_information(path, run%information, error)
            return
        end if
        call read_observations(path, observations, error)
        if (.not. allocated(error) .and. options_file /= '') call read_options(options_file, options, error)
        if (allocated(error)) return
        call run_from_observations(observations, options, run, error)
        call add_context(error, path)
        if (allocated(error)) return
        do i = 1, size(run%solution%warnings)
            call console%warn(path//': '//run%solution%warnings(i)%text)
        end do
    end subroutine read_run

    !> Runs that do not agree are told before anything else.
    subroutine warn_of_disagreement(kind, names, solution, console)
        character(*), intent(in) :: kind        !! runs or arcs
        type(string_t), intent(in) :: names(:)
        type(joint_solution_t), intent(in) :: solution
        type(console_t), intent(inout) :: console

        integer :: i, worst

        if (solution%consistent) return
        worst = minloc(solution%runs%probability, 1)
        call console%warn('the '//kind//' do not agree on one offset: chi square '//rounded_text(solution%statistic, 4)// &
                          ' for '//integer_text(solution%degrees)//' degrees of freedom, which chance reaches with a '// &
                          'probability of '//rounded_text(solution%probability, 2)//'; masses that moved between them '// &
                          'belong into --changes')
        do i = 1, size(solution%runs)
            associate (run => solution%runs(i))
                if (run%agrees .or. size(solution%runs) == 2 .and. i /= worst) cycle
                call console%warn(names(i)%text//' differs from the rest by '// &
                                  rounded_text(run%difference(1)/MILLIMETRE, 3)//', '// &
                                  rounded_text(run%difference(2)/MILLIMETRE, 3)//', '// &
                                  rounded_text(run%difference(3)/MILLIMETRE, 3)//' mm (sigma '// &
                                  rounded_text(run%difference_sigma(1)/MILLIMETRE, 2)//', '// &
                                  rounded_text(run%difference_sigma(2)/MILLIMETRE, 2)//', '// &
                                  rounded_text(run%difference_sigma(3)/MILLIMETRE, 2)//' mm)')
            end associate
        end do
    end subroutine warn_of_disagreement

    !> For people.
    subroutine show_joint(kind, names, epochs, solution, console)
        character(*), intent(in) :: kind            !! What is joined: runs or arcs
        type(string_t), intent(in) :: names(:)      !! Of each
        type(utc_t), intent(in) :: epochs(:)        !! Time 0 of each
        type(joint_solution_t), intent(in) :: solution
        type(console_t), intent(inout) :: console

        type(data_table_t) :: table, others
        character(100) :: line
        integer :: i, j

        call warn_of_disagreement(kind, names, solution, console)
        call console%line(integer_text(size(names))//' '//kind//', one offset at '// &
                          utc_text(epochs(solution%last))//' UTC')
        do i = 1, 3
            write (line, '("d", a1, f12.5, " +/-", f9.5, " mm")') 'xyz'(i:i), solution%offset(i)/MILLIMETRE, &
                sqrt(solution%covariance(i, i))/MILLIMETRE
            call console%line(trim(line))
        end do
        call console%line('')
        call console%line('each '//kind(:3)//' alone, and minus all others')
        call table%column('run', 'a', kind(:3))
        do i = 1, 3
            call table%column('d'//'xyz'(i:i)//'_mm', 'f10.4', trim(merge('d, mm|', '|     ', i == 1))//'xyz'(i:i))
        end do
        do i = 1, 3
            call table%column('difference_'//'xyz'(i:i)//'_mm', 'f10.4', &
                              trim(merge('difference, mm|', '|              ', i == 1))//'xyz'(i:i))
        end do
        do i = 1, 3
            call table%column('sigma_'//'xyz'(i:i)//'_mm', 'f9.4', trim(merge('its sigma, mm|', '|             ', i == 1))// &
                              'xyz'(i:i))
        end do
        call table%column('chi_square', 'f9.2', 'chi square|of 3')
        call table%column('variance_factor', 'f8.3', 'variance|factor')
        do i = 1, size(names)
            associate (run => solution%runs(i))
                call table%add(names(i)%text)
                call table%add([run%offset, run%difference, run%difference_sigma]/MILLIMETRE)
                call table%add(run%statistic)
                call table%add(run%squares/max(1, run%redundancy))
            end associate
        end do
        call console%table(table)
        call console%line('agreement         chi square '//rounded_text(solution%statistic, 4)//' for '// &
                          integer_text(solution%degrees)//' degrees of freedom, probability '// &
                          rounded_text(solution%probability, 3)//' (refused below '//rounded_text(FAMILY_LEVEL, 2)//')')
        if (.not. any(solution%parameter_sigma > 0)) return
        call console%line('')
        call console%line('what the '//kind//' share')
        call others%column('parameter', 'a', 'parameter')
        call others%column('value', 'es12.4', 'value')
        call others%column('sigma', 'es11.2', 'sigma')
        call others%column('unit', 'a', 'unit')
        do j = 1, JOINED_COUNT
            if (.not. solution%parameter_sigma(j) > 0) cycle
            call others%add(trim(PARAMETER_NAMES(JOINED(j))))
            call others%add([solution%parameter(j), solution%parameter_sigma(j)])
            call others%add(trim(PARAMETER_UNITS(JOINED(j))))
        end do
        call console%table(others)
    end subroutine show_joint

    !> As CSV or JSON: the joint estimate first, then each run alone.
    subroutine publish_joint(case, names, epochs, solution, console, error)
        character(*), intent(in) :: case            !! Member of JSON
        type(string_t), intent(in) :: names(:)      !! Of each run
        type(utc_t), intent(in) :: epochs(:)        !! Time 0 of each
        type(joint_solution_t), intent(in) :: solution
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results
        type(data_table_t) :: table
        real(dp) :: squares
        integer :: i, j

        call table%columns_of(COLUMNS)
        squares = sum(solution%runs%squares)/max(1, sum(solution%runs%redundancy))
        call table%add('joint')
        call table%add(utc_text(epochs(solution%last)))
        call table%add([solution%offset, [(sqrt(solution%covariance(i, i)), i=1, 3)]]/MILLIMETRE)
        do i = 1, 6
            call table%add_nothing()
        end do
        call table%add([solution%statistic, solution%probability])
        call table%add(solution%consistent)
        call table%add(squares)
        do i = 1, size(names)
            associate (run => solution%runs(i))
                call table%add(names(i)%text)
                call table%add(utc_text(epochs(i)))
                call table%add([run%offset, run%sigma, run%difference, run%difference_sigma]/MILLIMETRE)
                call table%add([run%statistic, run%probability])
                call table%add(run%agrees)
                call table%add(run%squares/max(1, run%redundancy))
            end associate
        end do
        call results%open('estimate')
        call results%member('case', case)
        call results%member('epoch_utc', utc_text(epochs(solution%last)))
        call results%member('offset_m', solution%offset)
        call results%begin('covariance')
        call results%member('matrix', solution%covariance)
        call results%end()
        call results%member('degrees_of_freedom', solution%degrees)
        call results%member('level', FAMILY_LEVEL)
        call results%begin_array('shared')
        do j = 1, JOINED_COUNT
            if (.not. solution%parameter_sigma(j) > 0) cycle
            call results%begin(on_one_line=.true.)
            call results%member('name', trim(PARAMETER_NAMES(JOINED(j))))
            call results%member('value', solution%parameter(j))
            call results%member('sigma', solution%parameter_sigma(j))
            call results%member('unit', trim(PARAMETER_UNITS(JOINED(j))))
            call results%end()
        end do
        call results%end()
        call results%publish(table, console, error)
    end subroutine publish_joint
end module gracecg_cli_joint
