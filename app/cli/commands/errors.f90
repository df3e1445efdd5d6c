!> gracecg errors: Figure 6.5 of CSR-TM-00-01, one error source off at a time.
module gracecg_cli_errors
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, join
    use gracecg_estimation_estimators, only: ESTIMATOR_NAMES
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_simulation_operator_errors, only: SOURCES
    use gracecg_studies_knowledge_errors, only: knowledge_study_t, study_all_knowledge, size_text
    use gracecg_studies_error_sources, only: error_study_t, study_all_errors, error_table, write_error_sources, &
        STUDY_NAMES
    use gracecg_files_file, only: check_writable
    use gracecg_cli_calibration_argument, only: add_options_option, add_cases_option, take_one_calibration, &
        warn_of_instruments
    use gracecg_cli_arguments, only: arguments_t, MOST_RUNS
    use gracecg_cli_console, only: console_t, console_width, wrapped
    use gracecg_cli_results, only: results_t, add_format_option, take_format
    implicit none
    private
    public :: declare_errors, run_errors

contains

    !> Arguments and help of `gracecg errors`.
    subroutine declare_errors(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('errors', '[CASE]', 0, 1, &
                                'The RMS error of the CG offset when one error source is switched off '// &
                                'at a time, as in Figure 6.5 of CSR-TM-00-01: all-noise, linear-ng (the '// &
                                'non-gravitational acceleration is a straight line in time), no-acc-noise, '// &
                                'no-sca-noise, no-mag-noise (neither noise nor bias of the magnetometer). '// &
                                'The estimator and its weights stay the same. Then what the operator may '// &
                                'know wrongly (group operator of the case file), each source alone: '// &
                                'its sigma is that of the case, else a priori, else a default size.', &
                                'gracecg errors back-1 --runs 50')
        call arguments%add_option('--runs', 'N', 'of each simulation (default 100)')
        call add_cases_option(arguments, 'front-1, as in the report', single=.true.)
        call arguments%add_option('--case', 'CASE', 'the same, as in version 0.1')
        call arguments%add_option('--algorithm', 'NAME', 'of '//join(ESTIMATOR_NAMES, ', ')// &
                                  ' (default ascfest, as in the report)', choices=ESTIMATOR_NAMES)
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--threads', 'N', 'to work on (default: the processors of the machine)')
        call arguments%add_option('--out', 'FILE', 'CSV file for the RMS errors')
        call add_format_option(arguments)
        call add_options_option(arguments)
    end subroutine declare_errors

    !> The work of `gracecg errors`.
    subroutine run_errors(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_t) :: calibration
        character(:), allocatable :: algorithm, path
        type(error_study_t) :: studies(size(STUDY_NAMES))
        type(knowledge_study_t) :: knowledge(size(SOURCES))
        type(results_t) :: results
        integer(i8) :: seed        !! Of the random numbers
        integer :: runs, threads, i

        call arguments%get('--runs', runs, misuse, default=100, low=1, high=MOST_RUNS)
        call arguments%get('--algorithm', algorithm, misuse, default='ascfest', choices=ESTIMATOR_NAMES)
        call arguments%get('--seed', seed, misuse, default=1_i8)
        call arguments%get_threads(threads, misuse)
        call arguments%get('--out', path, misuse, default='')
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return

        call check_writable(path, error)
        if (.not. allocated(error)) call take_one_calibration(arguments, 'front-1', console, calibration, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        call warn_of_instruments(calibration%case, console)
        call console%expect_parts(2, 'parts')
        call study_all_errors(calibration, algorithm, seed, runs, threads, studies, error, console)
        call console%next_part()
        if (.not. allocated(error)) call study_all_knowledge(calibration, algorithm, seed, runs, threads, knowledge, &
                                                             error, console)
        if (allocated(error)) return
        call show(trim(calibration%case%name)//', '//algorithm//', '//integer_text(runs)//' runs', studies, console)
        call show_knowledge(knowledge, console)
        call results%open('errors')
        call results%member('case', trim(calibration%case%name))
        call results%member('algorithm', algorithm)
        call results%member('seed', seed)
        call results%begin('knowledge_sizes')
        do i = 1, size(knowledge)
            call results%member(trim(SOURCES(knowledge(i)%source)%name), trim(size_text(knowledge(i))))
        end do
        call results%end()
        call results%publish(error_table(studies, knowledge), console, error)
        if (allocated(error)) return
        if (path /= '') call write_error_sources(path, 'errors', trim(calibration%case%name)//', '//algorithm// &
                                                 ', seed '//integer_text(seed), studies, error, knowledge)
    end subroutine run_errors

    subroutine show(title, studies, console)
        character(*), intent(in) :: title
        type(error_study_t), intent(in) :: studies(:)
        type(console_t), intent(inout) :: console

        character(100) :: row
        integer :: i, axis

        call console%line('RMS error of the CG offset, mm: '//title)
        call console%line('source           x here  x theory    y here  y theory    z here  z theory')
        do i = 1, size(STUDY_NAMES)
            write (row, '(a, t14, 6f10.5)') trim(STUDY_NAMES(i)), &
                (studies(i)%rms(axis)/MILLIMETRE, studies(i)%predicted(axis)/MILLIMETRE, axis=1, 3)
            call console%line(trim(row))
        end do
    end subroutine show

    subroutine show_knowledge(studies, console)
        type(knowledge_study_t), intent(in) :: studies(:)
        type(console_t), intent(inout) :: console

        integer, parameter :: NUMBERS = 58      ! Columns
        character(NUMBERS) :: row
        integer :: i, axis

        call console%line('')
        call console%paragraph('Knowledge of the operator that is wrong, each source alone, without noise: RMS change of '// &
                               'the CG offset, mm')
        call console%line('  x here  x theory    y here  y theory    z here  z theory  source')
        do i = 1, size(studies)
            write (row, '(f8.5, 5f10.5)') (studies(i)%rms(axis)/MILLIMETRE, studies(i)%predicted(axis)/MILLIMETRE, axis=1, 3)
            call console%line(row//'  '//wrapped(trim(size_text(studies(i))), NUMBERS + 3, console_width()))
        end do
    end subroutine show_knowledge
end module gracecg_cli_errors
