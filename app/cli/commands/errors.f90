!> gracecg errors: Figure 6.5 of CSR-TM-00-01, one error source off at a time.
module gracecg_cli_errors
    use gracecg_simulation_operator_errors, only: SOURCES
    use gracecg_studies_knowledge_errors, only: knowledge_study_t, study_all_knowledge, size_text
    use gracecg_studies_error_sources, only: error_study_t, study_all_errors, error_table, write_error_sources, &
        STUDY_NAMES
    use gracecg_cli_console, only: console_width, wrapped
    use gracecg_cli_work
    implicit none
    private
    public :: declare_errors, run_errors

contains

    !> Arguments and help of `gracecg errors`.
    subroutine declare_errors(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('errors', '[CASE]', 0, 1, &
                                'The RMS error of the CG offset of a case (default front-1) when one error source is '// &
                                'switched off at a time, as in Figure 6.5 of CSR-TM-00-01: all-noise, linear-ng (the '// &
                                'non-gravitational acceleration is a straight line in time), no-acc-noise, '// &
                                'no-sca-noise, no-mag-noise (neither noise nor bias of the magnetometer). '// &
                                'The estimator and its weights stay the same. Then what the operator may '// &
                                'know wrongly (group operator of the case file), each source alone: '// &
                                'its sigma is that of the case, else a priori, else a default size.', &
                                'gracecg errors back-1 --runs 50')
        call add_study_options(arguments, '--cases --runs --algorithm --seed --threads --out --format --options', 'ascfest', '100')
    end subroutine declare_errors

    !> The work of `gracecg errors`.
    subroutine run_errors(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(study_t) :: study
        character(:), allocatable :: title
        type(error_study_t) :: studies(size(STUDY_NAMES))
        type(knowledge_study_t) :: knowledge(size(SOURCES))
        type(results_t) :: results
        integer :: i

        call take_study(arguments, 'front-1', console, study, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        associate (calibration => study%calibrations(1), algorithm => study%algorithms(1)%text, seed => study%seed, &
                   runs => study%runs, threads => study%threads)
            call console%expect_parts(2, 'parts')
            call study_all_errors(calibration, algorithm, seed, runs, threads, studies, error, console)
            call console%next_part()
            if (.not. allocated(error)) call study_all_knowledge(calibration, algorithm, seed, runs, threads, knowledge, &
                                                                 error, console)
            title = trim(calibration%case%name)//', '//algorithm
        end associate
        if (allocated(error)) return
        call show(title//', '//integer_text(study%runs)//' runs', studies, console)
        call show_knowledge(knowledge, console)
        call results%open('errors')
        call results%member('case', trim(study%calibrations(1)%case%name))
        call results%member('algorithm', study%algorithms(1)%text)
        call results%member('seed', study%seed)
        call results%begin('knowledge_sizes')
        do i = 1, size(knowledge)
            call results%member(trim(SOURCES(knowledge(i)%source)%name), trim(size_text(knowledge(i))))
        end do
        call results%end()
        call results%publish(error_table(studies, knowledge), console, error)
        if (allocated(error)) return
        if (study%path /= '') call write_error_sources(study%path, 'errors', title//', seed '//integer_text(study%seed), studies, &
                                                       error, knowledge)
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
