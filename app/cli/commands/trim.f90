!> gracecg trim: calibrate, move the masses, calibrate again (step 5 of CSR-TM-00-01 section 5.1).
module gracecg_cli_trim
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: tell
    use gracecg_files_file, only: check_writable
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: integer_text, join, real_text
    use gracecg_files_data_table, only: data_table_t
    use gracecg_estimation_estimators, only: ESTIMATOR_NAMES
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_studies_trim, only: trim_settings_t, trim_round_t, trim_offset, trim_threshold, trim_statistics_t, &
        SIGMAS_OF_THRESHOLD, repeat_trim
    use gracecg_cli_calibration_argument, only: add_options_option, add_cases_option, take_one_calibration, &
        warn_of_instruments
    use gracecg_cli_arguments, only: arguments_t
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t, add_format_option, take_format
    implicit none
    private
    public :: declare_trim, run_trim

    character(*), parameter :: COLUMNS = 'round,dx_true_mm,dy_true_mm,dz_true_mm,'// &
                                         'dx_estimate_mm,dy_estimate_mm,dz_estimate_mm,'// &
                                         'sigma_x_mm,sigma_y_mm,sigma_z_mm'
    character(*), parameter :: STATISTICS_COLUMNS = 'round,dx_true_rms_mm,dy_true_rms_mm,dz_true_rms_mm,'// &
                               'dx_error_rms_mm,dy_error_rms_mm,dz_error_rms_mm,'// &
                               'sigma_x_mm,sigma_y_mm,sigma_z_mm'
    integer, parameter :: MOST_ROUNDS = 1000

contains

    !> Arguments and help of `gracecg trim`.
    subroutine declare_trim(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('trim', '[CASE]', 0, 1, &
                                'Calibrates a case (default front-1), moves masses so that the estimated '// &
                                'CG offset is cancelled, and calibrates again, until every component of '// &
                                'the estimate is below the threshold: step 5 of CSR-TM-00-01 section 5.1, '// &
                                'which the report left undone. The inertia about the proof-mass centre is '// &
                                'kept.', &
                                'gracecg trim front-3 --threshold-mm 0.1')
        call add_cases_option(arguments, 'front-1', single=.true.)
        call arguments%add_option('--threshold-mm', 'MM', 'of every component of the estimate (default: three times '// &
                                  'the sigma of each axis, as little as one calibration can tell from nothing)')
        call arguments%add_option('--rounds', 'N', 'calibrations at most (default 10)')
        call arguments%add_option('--balance-error', 'PART', 'relative error of the mass balancing of each '// &
                                  'axis, standard deviation (default 0.01)')
        call arguments%add_option('--balance-noise-mm', 'MM', 'absolute error of the mass balancing of each '// &
                                  'axis, standard deviation (default 0)')
        call arguments%add_option('--alone', '', 'each calibration alone, the earlier ones forgotten (default: all rounds '// &
                                  'count, with what was moved between and its error)')
        call arguments%add_option('--algorithm', 'NAME', 'of '//join(ESTIMATOR_NAMES, ', ')// &
                                  ' (default assest-fde)', choices=ESTIMATOR_NAMES)
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--runs', 'N', 'trim N times, with the seeds from S on, and show the RMS '// &
                                  'over the runs of as many rounds as --rounds says (then default 2); the '// &
                                  'threshold does not count')
        call arguments%add_option('--threads', 'N', 'for --runs (default: as many as there are processors)')
        call arguments%add_option('--out', 'FILE', 'CSV file for the rounds')
        call add_format_option(arguments)
        call add_options_option(arguments)
    end subroutine declare_trim

    !> The work of `gracecg trim`.
    subroutine run_trim(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_t) :: calibration
        type(trim_settings_t) :: settings
        type(trim_round_t), allocatable :: rounds(:)
        character(:), allocatable :: name, algorithm, path
        integer :: runs, threads

        call arguments%get('--algorithm', algorithm, misuse, default='assest-fde', choices=ESTIMATOR_NAMES)
        call arguments%get('--out', path, misuse, default='')
        call read_settings(arguments, settings, misuse)
        call arguments%get('--runs', runs, misuse, default=1, low=1, high=1000000)
        call arguments%get_threads(threads, misuse)
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return
        if (runs > 1 .and. .not. arguments%has('--rounds')) settings%rounds = 2
        call check_writable(path, error)
        if (allocated(error)) return

        call take_one_calibration(arguments, 'front-1', console, calibration, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        call warn_of_instruments(calibration%case, console)
        if (runs > 1) then
            call run_many(calibration, algorithm, settings, runs, threads, path, console, error)
            return
        end if
        call tell(console, 'trim of '//trim(calibration%case%name)//', '//algorithm)
        call trim_offset(calibration%case, algorithm, calibration%options, settings, rounds, error, console)
        if (allocated(error)) return
        name = trim(calibration%case%name)//', '//algorithm
        call show(name, rounds, console)
        call show_verdict(settings, rounds, console)
        call publish(calibration%case%name, algorithm, settings, 1, rounds_table(rounds), console, error)
        if (path /= '' .and. .not. allocated(error)) call write_file(path, name, settings, rounds_table(rounds), error)
    end subroutine run_trim

    !> RMS over many trims.
    subroutine run_many(calibration, algorithm, settings, runs, threads, path, console, error)
        type(calibration_t), intent(in) :: calibration
        character(*), intent(in) :: algorithm
        type(trim_settings_t), intent(in) :: settings
        integer, intent(in) :: runs, threads
        character(*), intent(in) :: path            !! Of the CSV file; empty: none
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(trim_statistics_t) :: statistics(settings%rounds)
        type(data_table_t) :: table
        character(:), allocatable :: name
        character(120) :: row
        integer :: i, axis

        name = trim(calibration%case%name)
        call tell(console, name)
        call console%expect(runs, 'trims')
        call repeat_trim(calibration%case, algorithm, calibration%options, settings, runs, threads, statistics, error, &
                         console)
        if (allocated(error)) return
        call console%paragraph('RMS over '//integer_text(runs)//' trims of '//name//', '//algorithm// &
                               ' (body axes, mm): true CG offset before each calibration, error of its estimate, and '// &
                               'sigma that the estimator states')
        call console%line('round     d_x true     error  sigma     d_y true     error  sigma     '// &
                          'd_z true     error  sigma')
        do i = 1, settings%rounds
            write (row, '(a, t9, 3(f10.5, f10.5, f8.5, :, 2x))') integer_text(i), &
                (statistics(i)%offset(axis)/MILLIMETRE, statistics(i)%estimate_error(axis)/MILLIMETRE, &
                 statistics(i)%sigma(axis)/MILLIMETRE, axis=1, 3)
            call console%line(trim(row))
        end do
        call table%columns_of(STATISTICS_COLUMNS)
        do i = 1, settings%rounds
            call table%add(i)
            call table%add([statistics(i)%offset, statistics(i)%estimate_error, statistics(i)%sigma]/MILLIMETRE)
        end do
        call publish(calibration%case%name, algorithm, settings, runs, table, console, error)
        if (path == '' .or. allocated(error)) return
        call table%write(path, &
                         [character(200) :: 'gracecg '//VERSION//' trim', name//', '// &
                          algorithm//', RMS over '//integer_text(runs)//' runs, seeds from '// &
                          integer_text(settings%seed)//', balancing error '//real_text(settings%balance_error)// &
                          ' and '//real_text(settings%balance_noise/MILLIMETRE)//' mm'], error)
    end subroutine run_many

    subroutine read_settings(arguments, settings, misuse)
        type(arguments_t), intent(in) :: arguments
        type(trim_settings_t), intent(out) :: settings
        type(error_t), allocatable, intent(inout) :: misuse

        type(trim_settings_t), parameter :: DEFAULT = trim_settings_t()
        real(dp), parameter :: MOST = 1000.0_dp     ! mm
        real(dp) :: threshold, noise                ! mm

        call arguments%get('--threshold-mm', threshold, misuse, default=DEFAULT%threshold/MILLIMETRE, &
                           low=1e-9_dp, high=MOST, unit='mm')
        call arguments%get('--rounds', settings%rounds, misuse, default=DEFAULT%rounds, low=1, &
                           high=MOST_ROUNDS)
        call arguments%get('--balance-error', settings%balance_error, misuse, default=DEFAULT%balance_error, &
                           low=0.0_dp, high=1.0_dp)
        call arguments%get('--balance-noise-mm', noise, misuse, default=0.0_dp, low=0.0_dp, high=MOST, &
                           unit='mm')
        call arguments%get('--seed', settings%seed, misuse, default=DEFAULT%seed)
        settings%threshold = threshold*MILLIMETRE
        settings%by_sigma = .not. arguments%has('--threshold-mm')
        settings%joint = .not. arguments%has('--alone')
        settings%balance_noise = noise*MILLIMETRE
    end subroutine read_settings

    subroutine show(title, rounds, console)
        character(*), intent(in) :: title
        type(trim_round_t), intent(in) :: rounds(:)
        type(console_t), intent(inout) :: console

        character(120) :: row
        integer :: i, axis

        call console%line('CG offset d (centre of mass to proof mass, body axes, mm) of each calibration: '// &
                          title)
        call console%line('round     d_x true  estimate  sigma     d_y true  estimate  sigma     '// &
                          'd_z true  estimate  sigma')
        do i = 1, size(rounds)
            write (row, '(a, t9, 3(f10.4, f10.4, f8.4, :, 2x))') integer_text(i), &
                (rounds(i)%offset(axis)/MILLIMETRE, rounds(i)%estimate(axis)/MILLIMETRE, &
                 rounds(i)%sigma(axis)/MILLIMETRE, axis=1, 3)
            call console%line(trim(row))
        end do
    end subroutine show

    !> Whether each axis converged; a warning where the threshold is below what an estimate can see.
    subroutine show_verdict(settings, rounds, console)
        type(trim_settings_t), intent(in) :: settings
        type(trim_round_t), intent(in) :: rounds(:)
        type(console_t), intent(inout) :: console

        character(:), allocatable :: verdict
        logical :: below, visible
        real(dp) :: threshold(3)
        integer :: axis

        threshold = trim_threshold(settings, rounds(size(rounds)))
        if (settings%by_sigma) call console%paragraph('threshold chosen: three times the sigma of each axis, x '// &
                                                 millimetres(threshold(1))//', y '//millimetres(threshold(2))//', z '// &
                                                 millimetres(threshold(3))//' mm (another one: --threshold-mm)')
        associate (latest => rounds(size(rounds)))
            do axis = 1, 3
                below = abs(latest%estimate(axis)) < threshold(axis)
                visible = latest%sigma(axis) <= threshold(axis)
                if (below .and. visible) then
                    verdict = 'converged'
                else if (visible) then
                    verdict = 'not converged in '//integer_text(size(rounds))//' rounds'
                else if (below) then
                    verdict = 'not converged: the estimate is below the threshold by chance'
                else
                    verdict = 'not converged, and more rounds do not help'
                end if
                call console%line(AXES(axis)//': '//verdict)
                if (.not. visible) call console%warn('the threshold of '// &
                                                        millimetres(threshold(axis))//' mm is below '// &
                                                        'the sigma of '//AXES(axis)//', '// &
                                                        millimetres(latest%sigma(axis))//' mm: a '// &
                                                        'calibration cannot see so little')
            end do
        end associate
    end subroutine show_verdict

    !> "0.1 mm", or where it is chosen "3 sigma of each axis".
    function threshold_text(settings) result(text)
        type(trim_settings_t), intent(in) :: settings
        character(:), allocatable :: text

        text = real_text(settings%threshold/MILLIMETRE)//' mm'
        if (settings%by_sigma) text = real_text(SIGMAS_OF_THRESHOLD)//' sigma of each axis'
    end function threshold_text

    function millimetres(length) result(text)
        real(dp), intent(in) :: length      !! m
        character(:), allocatable :: text

        character(12) :: digits

        write (digits, '(f12.4)') length/MILLIMETRE
        text = trim(adjustl(digits))
    end function millimetres

    subroutine write_file(path, title, settings, table, error)
        character(*), intent(in) :: path, title
        type(trim_settings_t), intent(in) :: settings
        type(data_table_t), intent(in) :: table
        type(error_t), allocatable, intent(out) :: error

        call table%write(path, &
                         [character(200) :: 'gracecg '//VERSION//' trim', title//', seed '// &
                          integer_text(settings%seed)//', threshold '//threshold_text(settings)//', balancing error '// &
                          real_text(settings%balance_error)//' and '// &
                          real_text(settings%balance_noise/MILLIMETRE)//' mm'], error)
    end subroutine write_file

    !> The rounds as a table of files.
    function rounds_table(rounds) result(table)
        type(trim_round_t), intent(in) :: rounds(:)
        type(data_table_t) :: table

        integer :: i

        call table%columns_of(COLUMNS)
        do i = 1, size(rounds)
            call table%add(i)
            call table%add([rounds(i)%offset, rounds(i)%estimate, rounds(i)%sigma]/MILLIMETRE)
        end do
    end function rounds_table

    !> The rounds as CSV or JSON.
    subroutine publish(case_name, algorithm, settings, runs, table, console, error)
        character(*), intent(in) :: case_name, algorithm
        type(trim_settings_t), intent(in) :: settings
        integer, intent(in) :: runs
        type(data_table_t), intent(in) :: table
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results

        call results%open('trim')
        call results%member('case', trim(case_name))
        call results%member('algorithm', algorithm)
        call results%member('seed', settings%seed)
        call results%member('runs', runs)
        if (settings%by_sigma) then
            call results%member('threshold_sigmas', SIGMAS_OF_THRESHOLD)
        else
            call results%member('threshold_mm', settings%threshold/MILLIMETRE)
        end if
        call results%member('balance_error', settings%balance_error)
        call results%member('all_rounds_count', settings%joint)
        call results%member('balance_noise_mm', settings%balance_noise/MILLIMETRE)
        call results%publish(table, console, error)
    end subroutine publish
end module gracecg_cli_trim
