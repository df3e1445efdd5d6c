!> gracecg errors: Figure 6.5 of CSR-TM-00-01, one error source off at a time.
module gracecg_command_errors
    use omp_lib, only: omp_get_num_procs
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t
    use gracecg_version, only: VERSION
    use gracecg_text, only: integer_text, join
    use gracecg_csv, only: csv_writer_t
    use gracecg_estimators, only: ESTIMATOR_NAMES
    use gracecg_calibration_case, only: calibration_case_t
    use gracecg_case_library, only: find_calibration
    use gracecg_simulation, only: simulator_t
    use gracecg_monte_carlo, only: monte_carlo_t, run_monte_carlo, error_statistics_t, statistics_of, &
        prediction_t, predict_errors
    use gracecg_error_sources, only: new_switched_simulator, study_switches, STUDY_NAMES
    use gracecg_file, only: check_writable
    use gracecg_arguments, only: arguments_t
    use gracecg_console, only: console_t
    implicit none
    private
    public :: declare_errors, run_errors

    character(1), parameter :: AXES(3) = ['x', 'y', 'z']
    integer, parameter :: MOST_RUNS = 10000000, MOST_THREADS = 1024
    real(dp), parameter :: MILLIMETRE = 1e-3_dp     !! m

contains

    subroutine declare_errors(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('errors', '', 0, 0, &
                                'The RMS error of the CG offset when one error source is switched off '// &
                                'at a time, as in Figure 6.5 of CSR-TM-00-01: all-noise, linear-ng (the '// &
                                'non-gravitational acceleration is a straight line in time), no-acc-noise, '// &
                                'no-sca-noise, no-mag-noise (neither noise nor bias of the magnetometer). '// &
                                'The estimator and its weights stay the same.', &
                                'gracecg errors --runs 50')
        call arguments%add_option('--runs', 'N', 'of each simulation (default 100)')
        call arguments%add_option('--case', 'CASE', 'name or namelist file (default front-1, as in the report)')
        call arguments%add_option('--algorithm', 'NAME', 'of '//join(ESTIMATOR_NAMES, ', ')// &
                                  ' (default ascfest, as in the report)')
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--threads', 'N', 'to work on (default: the processors of the machine)')
        call arguments%add_option('--out', 'FILE', 'CSV file for the RMS errors')
    end subroutine declare_errors

    subroutine run_errors(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_case_t) :: case
        character(:), allocatable :: case_name, algorithm, path
        real(dp) :: rms(3, size(STUDY_NAMES)), predicted(3, size(STUDY_NAMES))
        integer :: runs, seed, threads, i

        call arguments%get('--runs', runs, misuse, default=100, low=1, high=MOST_RUNS)
        if (.not. allocated(misuse)) call arguments%get('--case', case_name, misuse, default='front-1')
        if (.not. allocated(misuse)) call arguments%get('--algorithm', algorithm, misuse, default='ascfest', &
                                                        choices=ESTIMATOR_NAMES)
        if (.not. allocated(misuse)) call arguments%get('--seed', seed, misuse, default=1)
        if (.not. allocated(misuse)) call arguments%get('--threads', threads, misuse, &
                                                        default=omp_get_num_procs(), low=1, high=MOST_THREADS)
        if (.not. allocated(misuse)) call arguments%get('--out', path, misuse, default='')
        if (allocated(misuse)) return

        call check_writable(path, error)
        if (.not. allocated(error)) call find_calibration(case_name, case, error)
        if (allocated(error)) return
        do i = 1, size(STUDY_NAMES)
            call console%progress('errors: '//trim(STUDY_NAMES(i))//', '//integer_text(runs)//' runs')
            call study(case, trim(STUDY_NAMES(i)), algorithm, seed, runs, threads, rms(:, i), &
                       predicted(:, i), error)
            if (allocated(error)) return
        end do
        call show(trim(case%setup%name)//', '//algorithm//', '//integer_text(runs)//' runs', rms, predicted, &
                  console)
        if (path /= '') call write_file(path, trim(case%setup%name)//', '//algorithm//', seed '// &
                                        integer_text(seed), runs, rms, error)
    end subroutine run_errors

    !> RMS errors of one simulation, ours and by theory, mm.
    subroutine study(case, name, algorithm, seed, runs, threads, rms, predicted, error)
        type(calibration_case_t), intent(in) :: case
        character(*), intent(in) :: name            !! Of STUDY_NAMES
        character(*), intent(in) :: algorithm
        integer, intent(in) :: seed, runs, threads
        real(dp), intent(out) :: rms(3), predicted(3)
        type(error_t), allocatable, intent(out) :: error

        type(simulator_t) :: simulator
        type(monte_carlo_t) :: results
        type(error_statistics_t) :: statistics
        type(prediction_t) :: prediction
        integer :: i

        rms = 0
        predicted = 0
        call new_switched_simulator(case, study_switches(name), simulator, error)
        if (.not. allocated(error)) call predict_errors(simulator, algorithm, prediction, error)
        if (.not. allocated(error)) call run_monte_carlo(simulator, algorithm, seed, [(i, i=1, runs)], &
                                                         threads, results, error)
        if (allocated(error)) return
        statistics = statistics_of(results%offset/MILLIMETRE, case%offset/MILLIMETRE)
        rms = statistics%rms
        predicted = prediction%rms/MILLIMETRE
    end subroutine study

    subroutine show(title, rms, predicted, console)
        character(*), intent(in) :: title
        real(dp), intent(in) :: rms(:, :), predicted(:, :)      !! (axis, study), mm
        type(console_t), intent(inout) :: console

        character(100) :: row
        integer :: i, axis

        call console%line('RMS error of the CG offset, mm: '//title)
        call console%line('source           x here  x theory    y here  y theory    z here  z theory')
        do i = 1, size(STUDY_NAMES)
            write (row, '(a, t14, 6f10.5)') trim(STUDY_NAMES(i)), &
                (rms(axis, i), predicted(axis, i), axis=1, 3)
            call console%line(trim(row))
        end do
    end subroutine show

    subroutine write_file(path, settings, runs, rms, error)
        character(*), intent(in) :: path
        character(*), intent(in) :: settings
        integer, intent(in) :: runs
        real(dp), intent(in) :: rms(:, :)           !! (axis, study), mm
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        integer :: i, axis

        call file%open(path, 'source,axis,runs,rms_mm', &
                       [character(120) :: 'gracecg '//VERSION//' errors', settings], error)
        if (allocated(error)) return
        do i = 1, size(STUDY_NAMES)
            do axis = 1, 3
                call file%row([real(runs, dp), rms(axis, i)], [character(12) :: STUDY_NAMES(i), AXES(axis)])
            end do
        end do
        call file%commit(error)
    end subroutine write_file
end module gracecg_command_errors
