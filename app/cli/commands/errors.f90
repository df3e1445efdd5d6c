!> gracecg errors: Figure 6.5 of CSR-TM-00-01, one error source off at a time.
module gracecg_cli_errors
    use gracecg_studies_error_sources, only: error_study_t, study_all_errors, error_table, STUDY_NAMES
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
                                'The estimator and its weights stay the same.', &
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
        type(results_t) :: results

        call take_study(arguments, 'front-1', console, study, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        associate (calibration => study%calibrations(1), algorithm => study%algorithms(1)%text)
            call study_all_errors(calibration, algorithm, study%seed, study%runs, study%threads, studies, error, console)
            title = trim(calibration%case%name)//', '//algorithm
        end associate
        if (allocated(error)) return
        call console%line('RMS error of the CG offset, mm: '//title//', '//integer_text(study%runs)//' runs')
        call console%table(error_table(studies))
        call results%open('errors')
        call results%member('case', trim(study%calibrations(1)%case%name))
        call results%member('algorithm', study%algorithms(1)%text)
        call results%member('seed', study%seed)
        call results%publish(error_table(studies), console, error, study%path, title//', seed '//integer_text(study%seed))
    end subroutine run_errors
end module gracecg_cli_errors
