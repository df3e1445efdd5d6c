!> gracecg simulate: the true arc of a case and one noisy observation set.
module gracecg_cli_simulate
    use gracecg_base_version, only: VERSION
    use gracecg_files_file, only: file_exists, make_directory, remove_file, text_file_t, read_text_file
    use gracecg_files_run_record, only: note_file, note_output, UPDATED
    use gracecg_observations_observation_files, only: OBSERVATION_FILES, SETUP_FILE
    use gracecg_estimation_arc_chain, only: USUAL_ARC
    use gracecg_estimation_plausibility, only: longest_arc
    use gracecg_estimation_options, only: estimation_options_t, write_options, OPTIONS_FILE
    use gracecg_simulation_operator_view, only: operator_knowledge
    use gracecg_simulation_simulation_files, only: simulation_order_t, simulation_summary_t, simulate_into, TRUTH_FILE
    use gracecg_cli_calibration_argument, only: take_calibration, warn_of_field
    use gracecg_cli_console, only: quoted_word
    use gracecg_cli_work
    implicit none
    private
    public :: declare_simulate, run_simulate

contains

    !> Arguments and help of `gracecg simulate`.
    subroutine declare_simulate(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('simulate', 'CASE', 1, 1, &
                                'Propagates the true orbit and attitude of a case and draws '// &
                                'one noisy observation set. CASE is a built-in case (gracecg '// &
                                'cases) or a namelist file. Seed and run alone decide the '// &
                                'random numbers.', &
                                'gracecg simulate front-1 --out run1 --seed 1 --run 1')
        call arguments%add_option('--out', 'DIR', 'folder for '//TRUTH_FILE//' and the observation set; made if it is not '// &
                                  'there', required=.true.)
        call add_study_options(arguments, '--seed --run')
        call arguments%add_option('--rods', 'S', 'also writes rods.csv, the moments that the torque rods truly '// &
                                  'had, every S seconds: estimate takes them in place of those commanded')
    end subroutine declare_simulate

    !> The work of `gracecg simulate`.
    subroutine run_simulate(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_t) :: calibration
        type(simulation_order_t) :: order
        type(simulation_summary_t) :: summary
        character(:), allocatable :: before

        call arguments%get('--out', order%folder, misuse)
        call arguments%get('--seed', order%seed, misuse)
        call arguments%get('--run', order%run, misuse, low=0)
        call arguments%get('--rods', order%rods_interval, misuse, low=1e-3_dp, high=10.0_dp)
        if (allocated(misuse)) return

        call take_calibration(arguments, arguments%positional(1), calibration, error, may_rest=.true.)
        if (allocated(error)) return
        order%case = calibration%case
        call find_earlier(order%folder//'/'//trim(OBSERVATION_FILES(SETUP_FILE)), before)
        call write_run(order, calibration%options, summary, error)
        if (allocated(error)) return
        call warn_of_field(order%case%field_model, order%case%epoch, console)
        call console%warn_all(summary%warnings)
        if (before /= '' .and. index(before, trim(order%case%name)//',') /= 1) call console%warn(order%folder//' held a '// &
            'simulation of case '//before//', which this one has replaced')
        call report(order, summary, file_exists(arguments%positional(1)), console)
    end subroutine run_simulate

    !> Which simulation a folder holds: name of its case, seed, run; empty: none.
    subroutine find_earlier(setup, before)
        character(*), intent(in) :: setup       !! Path, where it is
        character(:), allocatable, intent(out) :: before

        character(*), parameter :: MARK = '! case '
        type(text_file_t) :: file
        type(error_t), allocatable :: unreadable
        integer :: i

        before = ''
        if (.not. file_exists(setup)) return
        call note_file(setup, UPDATED)          ! looked at, and then replaced
        call read_text_file(setup, file, unreadable)
        if (allocated(unreadable)) return
        do i = 1, file%line_count()
            if (index(file%line(i), MARK) /= 1) cycle
            before = file%line(i)
            before = before(len(MARK) + 1:)
            return
        end do
    end subroutine find_earlier

    !> Writes the truth, the observation set and the options; after a failure none of them.
    subroutine write_run(order, options, summary, error)
        type(simulation_order_t), intent(inout) :: order
        type(estimation_options_t), intent(in) :: options
        type(simulation_summary_t), intent(out) :: summary
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: setup

        setup = order%folder//'/'//trim(OBSERVATION_FILES(SETUP_FILE))      ! which is written last
        if (file_exists(setup) .and. .not. (file_exists(order%folder//'/'//TRUTH_FILE) .and. &
                                            file_exists(order%folder//'/'//OPTIONS_FILE))) then
            call fail(error, order%folder//' holds data that are no simulation of this command (without '//TRUTH_FILE//' or '// &
                      OPTIONS_FILE//'), and would be lost: take another folder')
            return
        end if
        call note_output(setup, error)
        if (.not. allocated(error)) call make_directory(order%folder, error)
        if (allocated(error)) return
        order%comments = [character(100) :: 'gracecg '//VERSION//' simulate', 'case '//trim(order%case%name)//', seed '// &
                          integer_text(order%seed)//', run '//integer_text(order%run)]
        call write_options(order%folder//'/'//OPTIONS_FILE, options, order%comments, error)
        if (allocated(error)) return
        call simulate_into(order, summary, error)
        if (allocated(error)) call remove_file(order%folder//'/'//OPTIONS_FILE)
    end subroutine write_run

    !> What was written, and what to do next.
    subroutine report(order, summary, own, console)
        type(simulation_order_t), intent(in) :: order
        type(simulation_summary_t), intent(in) :: summary
        logical, intent(in) :: own      !! The case is the user's file: its manoeuvre need not be the report's
        type(console_t), intent(inout) :: console

        character(16) :: how
        integer :: i

        call console%line('written to '//order%folder//':')
        call console%line('  '//TRUTH_FILE//'          the true arc')
        do i = 1, size(summary%rows)
            if (i > 4 .and. summary%rows(i) == 0) cycle     ! moments of the rods, where nobody asked for them
            call console%line('  '//OBSERVATION_FILES(i)(:max(17, len_trim(OBSERVATION_FILES(i))))//'  '// &
                              integer_text(summary%rows(i))//trim(merge(' positions', ' samples  ', i == 4)))
        end do
        call console%line('  '//OBSERVATION_FILES(SETUP_FILE)(:17)//'  what the operator knows')
        call console%line('  '//OPTIONS_FILE//'        how the case is estimated')
        if (summary%moves_rods) then
            how = merge('optimal         ', 'assest-fde      ', own)
            if (order%case%duration > USUAL_ARC .and. order%case%control%acts .or. &
                order%case%duration > longest_arc(operator_knowledge(order%case, order%case%operator))) how = 'optimal --arc 60'
            call console%line('next: gracecg estimate '//quoted_word(order%folder)//' --algorithm '//trim(how))
        else
            call console%warn('all '//trim(merge('torquers   ', 'torque rods', order%case%satellite%rods%direct))// &
                              ' are off: from these observations no CG offset can be estimated')
        end if
    end subroutine report
end module gracecg_cli_simulate
