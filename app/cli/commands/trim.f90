!> gracecg trim: calibrate, move the masses, calibrate again (step 5 of CSR-TM-00-01 section 5.1).
module gracecg_cli_trim
    use gracecg_estimation_action, only: DO_NOT_USE
    use gracecg_studies_trim, only: trim_settings_t, trim_round_t, trim_offset, trim_threshold, trim_statistics_t, &
        SIGMAS_OF_THRESHOLD, repeat_trim
    use gracecg_cli_work
    implicit none
    private
    public :: declare_trim, run_trim

    integer, parameter :: MOST_ROUNDS = 1000
    real(dp), parameter :: MOST = 1000.0_dp         !! Of lengths, mm

contains

    !> Arguments and help of `gracecg trim`.
    subroutine declare_trim(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('trim', '[CASE]', 0, 1, &
                                'Calibrates a case (default front-1), moves masses so that the estimated '// &
                                'CG offset is cancelled, and calibrates again, until every component of '// &
                                'the estimate is below the threshold: step 5 of CSR-TM-00-01 section 5.1, '// &
                                'which the report left undone. Along an axis that `estimate` would not move, nothing is moved. '// &
                                'The inertia about the proof-mass centre is '// &
                                'kept. With --runs it trims N times, with the seeds from S on, and shows the RMS over the '// &
                                'runs of as many rounds as --rounds says (then default 2); the threshold does not count.', &
                                'gracecg trim front-3 --threshold-mm 0.1')
        call add_study_options(arguments, '--cases')
        call arguments%add_option('--threshold-mm', 'MM', 'of every component of the estimate (default: three times '// &
                                  'the sigma of each axis, as little as one calibration can tell from nothing)')
        call arguments%add_option('--rounds', 'N', 'calibrations at most (default 10)')
        call arguments%add_option('--balance-error', 'PART', 'relative error of the mass balancing of each '// &
                                  'axis, standard deviation', default='0.01')
        call arguments%add_option('--balance-noise-mm', 'MM', 'absolute error of the mass balancing of each '// &
                                  'axis, standard deviation', default='0')
        call arguments%add_option('--alone', '', 'each calibration alone, the earlier ones forgotten (default: all rounds '// &
                                  'count, with what was moved between and its error)')
        call add_study_options(arguments, '--algorithm --seed --runs --threads --out --format --options', 'assest-fde', '1')
    end subroutine declare_trim

    !> The work of `gracecg trim`.
    subroutine run_trim(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(study_t) :: study
        type(trim_settings_t) :: settings
        type(data_table_t) :: table

        call read_settings(arguments, settings, misuse)
        call take_study(arguments, 'front-1', console, study, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        settings%seed = study%seed
        call tell(console, 'trim of '//title_of(study))
        if (study%runs > 1) then
            if (.not. arguments%has('--rounds')) settings%rounds = 2
            call trim_many(study, settings, table, console, error)
        else
            call trim_once(study, settings, table, console, error)
        end if
        if (.not. allocated(error)) call publish(study, settings, table, console, error)
    end subroutine run_trim

    subroutine read_settings(arguments, settings, misuse)
        type(arguments_t), intent(in) :: arguments
        type(trim_settings_t), intent(out) :: settings
        type(error_t), allocatable, intent(inout) :: misuse

        settings%threshold = settings%threshold/MILLIMETRE
        call arguments%get('--threshold-mm', settings%threshold, misuse, low=1e-9_dp, high=MOST, unit='mm')
        call arguments%get('--rounds', settings%rounds, misuse, low=1, high=MOST_ROUNDS)
        call arguments%get('--balance-error', settings%balance_error, misuse, low=0.0_dp, high=1.0_dp)
        call arguments%get('--balance-noise-mm', settings%balance_noise, misuse, low=0.0_dp, high=MOST, unit='mm')
        settings%threshold = settings%threshold*MILLIMETRE
        settings%balance_noise = settings%balance_noise*MILLIMETRE
        settings%by_sigma = .not. arguments%has('--threshold-mm')
        settings%joint = .not. arguments%has('--alone')
    end subroutine read_settings

    !> Case and algorithm.
    function title_of(study) result(text)
        type(study_t), intent(in) :: study
        character(:), allocatable :: text

        text = trim(study%calibrations(1)%case%name)//', '//study%algorithms(1)%text
    end function title_of

    !> The rounds of one trim, and whether they converged.
    subroutine trim_once(study, settings, table, console, error)
        type(study_t), intent(in) :: study
        type(trim_settings_t), intent(in) :: settings
        type(data_table_t), intent(out) :: table
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(trim_round_t), allocatable :: rounds(:)
        integer :: i

        associate (calibration => study%calibrations(1))
            call trim_offset(calibration%case, study%algorithms(1)%text, calibration%options, settings, rounds, error, console)
        end associate
        if (allocated(error)) return
        call declare_columns('_true_mm', 'true, mm', '_estimate_mm', 'estimate', table)
        do i = 1, size(rounds)
            call table%add(i)
            call table%add([rounds(i)%offset, rounds(i)%estimate, rounds(i)%sigma]/MILLIMETRE)
        end do
        call console%line('CG offset d (centre of mass to proof mass, body axes) of each calibration: '//title_of(study))
        call console%table(table)
        associate (latest => rounds(size(rounds)))
            if (any(latest%action%again)) call console%paragraph('round '//integer_text(size(rounds))//': '//latest%action%text)
            call show_verdict(settings, latest, size(rounds), console)
        end associate
    end subroutine trim_once

    !> RMS over many trims.
    subroutine trim_many(study, settings, table, console, error)
        type(study_t), intent(in) :: study
        type(trim_settings_t), intent(in) :: settings
        type(data_table_t), intent(out) :: table
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(trim_statistics_t) :: statistics(settings%rounds)
        integer :: i

        call console%expect(study%runs, 'trims')
        associate (calibration => study%calibrations(1))
            call repeat_trim(calibration%case, study%algorithms(1)%text, calibration%options, settings, study%runs, &
                             study%threads, statistics, error, console)
        end associate
        if (allocated(error)) return
        call declare_columns('_true_rms_mm', 'true, mm', '_error_rms_mm', 'error', table)
        do i = 1, settings%rounds
            call table%add(i)
            call table%add([statistics(i)%offset, statistics(i)%estimate_error, statistics(i)%sigma]/MILLIMETRE)
        end do
        call console%paragraph('RMS over '//integer_text(study%runs)//' trims of '//title_of(study)// &
                               ' (body axes): true CG offset before each calibration, error of its estimate, and '// &
                               'sigma that the estimator states')
        call console%table(table)
    end subroutine trim_many

    subroutine declare_columns(true_offset, true_heading, estimate, estimate_heading, table)
        character(*), intent(in) :: true_offset, estimate       !! Endings of the names
        character(*), intent(in) :: true_heading, estimate_heading
        type(data_table_t), intent(inout) :: table

        call table%column('round', 'i4', 'round')
        call axis_columns(table, 'd', true_offset, 'f9.4', true_heading)
        call axis_columns(table, 'd', estimate, 'f9.4', estimate_heading)
        call axis_columns(table, 'sigma_', '_mm', 'f9.4', 'sigma')
    end subroutine declare_columns

    !> Whether each axis converged; a warning where the threshold is below what an estimate can see.
    subroutine show_verdict(settings, latest, rounds, console)
        type(trim_settings_t), intent(in) :: settings
        type(trim_round_t), intent(in) :: latest    !! The last round
        integer, intent(in) :: rounds               !! How many there were
        type(console_t), intent(inout) :: console

        character(:), allocatable :: verdict
        logical :: below, visible
        real(dp) :: threshold(3)
        integer :: axis

        threshold = trim_threshold(settings, latest)
        if (settings%by_sigma) call console%paragraph('threshold chosen: three times the sigma of each axis, x '// &
                                                 millimetres(threshold(1))//', y '//millimetres(threshold(2))//', z '// &
                                                 millimetres(threshold(3))//' mm (another one: --threshold-mm)')
        do axis = 1, 3
            below = abs(latest%estimate(axis)) < threshold(axis)
            visible = latest%sigma(axis) <= threshold(axis)
            if (latest%action%kind == DO_NOT_USE) then
                verdict = 'not converged: no masses were moved'
            else if (latest%action%again(axis)) then
                verdict = 'not determined: no masses are moved along it'
            else if (below .and. visible) then
                verdict = 'converged'
            else if (visible) then
                verdict = 'not converged in '//integer_text(rounds)//' rounds'
            else if (below) then
                verdict = 'not converged: the estimate is below the threshold by chance'
            else
                verdict = 'not converged, and more rounds do not help'
            end if
            call console%line(AXES(axis)//': '//verdict)
            if (.not. visible) call console%warn('the threshold of '//millimetres(threshold(axis))//' mm is below the sigma of '// &
                                                 AXES(axis)//', '//millimetres(latest%sigma(axis))//' mm: a '// &
                                                 'calibration cannot see so little')
        end do
    end subroutine show_verdict

    function millimetres(length) result(text)
        real(dp), intent(in) :: length      !! m
        character(:), allocatable :: text

        character(12) :: digits

        write (digits, '(f12.4)') length/MILLIMETRE
        text = trim(adjustl(digits))
    end function millimetres

    !> The rounds as CSV or JSON, and into the file.
    subroutine publish(study, settings, table, console, error)
        type(study_t), intent(in) :: study
        type(trim_settings_t), intent(in) :: settings
        type(data_table_t), intent(in) :: table
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results
        character(:), allocatable :: about

        about = title_of(study)//', '//integer_text(study%runs)//' runs, seed '//integer_text(study%seed)//', threshold '
        call results%open('trim')
        call results%member('case', trim(study%calibrations(1)%case%name))
        call results%member('algorithm', study%algorithms(1)%text)
        call results%member('seed', study%seed)
        call results%member('runs', study%runs)
        if (settings%by_sigma) then
            call results%member('threshold_sigmas', SIGMAS_OF_THRESHOLD)
            about = about//real_text(SIGMAS_OF_THRESHOLD)//' sigma of each axis'
        else
            call results%member('threshold_mm', settings%threshold/MILLIMETRE)
            about = about//real_text(settings%threshold/MILLIMETRE)//' mm'
        end if
        call results%member('balance_error', settings%balance_error)
        call results%member('all_rounds_count', settings%joint)
        call results%member('balance_noise_mm', settings%balance_noise/MILLIMETRE)
        call results%publish(table, console, error, study%path, about//', balancing error '// &
                             real_text(settings%balance_error)//' and '//real_text(settings%balance_noise/MILLIMETRE)//' mm')
    end subroutine publish
end module gracecg_cli_trim
