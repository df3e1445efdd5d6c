!> Where a manoeuvre lies in Level-1 files: in those of several days, and its spans by currents, events and what is said.
module test_level1_days
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_null_char, c_size_t
    use vocabulary
    use c_library, only: error_struct, gracecg_level1_estimate, gracecg_free, item, message_text
    use f77_interfaces, only: gcl1dy
    use gracecg_files_file, only: make_directory
    use gracecg_level1_events, only: level1_event_t, read_events, manoeuvre_spans
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_gathering, only: gather_calibration
    use gracecg_level1_estimation, only: estimate_level1
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_spans, only: find_spans
    use command_fixture, only: succeeds
    use level1_day, only: flaws_t, setup_said, start_of, write_day, copy_day, day_fails, says, make_setup, EPOCH, DURATION
    implicit none
    private
    public :: collect_level1_days

contains

    subroutine collect_level1_days(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('over-midnight', test_midnight), &
                    new_unittest('several-days', test_several_days), &
                    new_unittest('longest-span', test_longest_span), &
                    new_unittest('spans-by-currents', test_spans), &
                    new_unittest('events', test_events)]
    end subroutine collect_level1_days

    !> A manoeuvre whose files end within a span and go on in those of the next day, three seconds of which are in both,
    !> gives what it gives in one file.
    subroutine test_midnight(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_calibration_t) :: whole, parted
        type(level1_estimate_t) :: expected, found
        type(error_t), allocatable :: failure
        character(:), allocatable :: output, messages
        real(dp) :: middle
        integer :: i

        if (day_fails(error, 'l1_whole', flaws_t(spans=2, leakage=1e-12_dp), setup_said(), whole, expected)) return
        middle = start_of(0) + DURATION/2
        call copy_day(FOLDER//'l1_whole', FOLDER//'l1_parted', '2020-02-01', -1e4_dp, middle + 3, 0)
        call copy_day(FOLDER//'l1_whole', FOLDER//'l1_parted', '2020-02-02', middle, 1e4_dp, 0)
        call gather_calibration([FOLDER//'l1_parted'], setup_said(), '', '', reshape([real(dp) ::], [2, 0]), 'model', &
                                parted, failure)
        if (.not. allocated(failure)) call estimate_level1(parted, setup_said(), 'estimate', found, failure)
        if (failed(error, failure)) return
        call check(error, says(parted%notes, 'files of 2 days are joined, 2020-02-01 to 2020-02-02'), 'days are told')
        call check(error, says(parted%notes, 'ACC1A: 30 records have an epoch that came before'), 'records that are there twice')
        call check(error, says(parted%notes, 'MAG1B: 1 records came before an earlier one'), 'order')
        ! No SOE file: the spans are those of the currents.
        if (unmet(error, parted%spans_from == 'the currents' .and. size(parted%spans) == 2, 'spans')) return
        call check(error, maxval(abs(parted%spans%start - whole%spans%start)) < 0.6_dp .and. &
                   maxval(abs(parted%spans%stop - whole%spans%stop)) < 0.6_dp, 'begin and end')
        call gather_calibration([FOLDER//'l1_parted'], setup_said(), '', '', &
                                reshape([(EPOCH + start_of(i), DURATION, i=0, 1)], [2, 2]), 'model', parted, failure)
        if (.not. allocated(failure)) call estimate_level1(parted, setup_said(), 'estimate', found, failure)
        if (failed(error, failure)) return
        do i = 1, size(found%solutions)
            call check(error, maxval(abs(found%solutions(i)%offset - expected%solutions(i)%offset)) < 1e-6_dp*MICROMETRE, &
                       found%solutions(i)%source)
            call check(error, all(abs(found%solutions(i)%covariance - expected%solutions(i)%covariance) < &
                                  1e-6_dp*maxval(abs(expected%solutions(i)%covariance))), 'covariance')
        end do
        call succeeds(error, 'level1 list '//FOLDER//'l1_parted', output, messages)
        call check_says(error, output//messages, 's before the last record of ACC1A_2020-02-01_C_04.txt')
    end subroutine test_midnight

    !> Two manoeuvres three days apart in one folder: which is meant has to be said, by its day, and is then taken.
    subroutine test_several_days(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_calibration_t) :: calibration
        type(error_t), allocatable :: failure
        character(:), allocatable :: path
        real(dp) :: none(2, 0)
        integer(i8) :: start
        integer :: i

        call write_day('l1_first', flaws_t(spans=1), path)
        call copy_day(path, FOLDER//'l1_days', '2020-02-01', -1e4_dp, 1e4_dp, 0)
        call copy_day(path, FOLDER//'l1_days', '2020-02-04', -1e4_dp, 1e4_dp, 3*86400)
        call gather_calibration([FOLDER//'l1_days'], setup_said(), '', '', none, 'model', calibration, failure)
        call check_fails(error, failure, '2 manoeuvres ... 2020-02-01T03:01 (1 spans) ... 2020-02-04T03:01 (1 spans) ... --day')
        call gather_calibration([FOLDER//'l1_days'], setup_said(), '', '', none, 'model', calibration, failure, '2020-02-04')
        if (failed(error, failure)) return
        call check(error, calibration%date, '2020-02-04')
        call check(error, size(calibration%spans) == 1 .and. calibration%epoch >= EPOCH + 3*86400 .and. &
                   calibration%spans(1)%used, 'its span')
        call check_day_from_c(error)
        if (allocated(error)) return
        call gather_calibration([FOLDER//'l1_days'], setup_said(), '', '', none, 'model', calibration, failure, '2020-02-03')
        call check_fails(error, failure, 'no Level-1 files of 2020-02-03')
        call gather_calibration([FOLDER//'l1_days'], setup_said(), '', '', none, 'model', calibration, failure, '2020-02-30')
        call check_fails(error, failure, '"2020-02-30" is no date')
        ! Each day has an SOE file of its own: all count
        do i = 1, 2
            call make_directory(FOLDER//'l1_soe_'//integer_text(i), failure)
            start = EPOCH + nint(start_of(0), i8) + (i - 1)*3*86400
            call make_file('l1_soe_'//integer_text(i)//'/SOE.txt', integer_text(start)//'.000 GRACEC CMCAL 1 1 start'//achar(10)// &
                           integer_text(start + 60)//'.000 GRACEC CMCAL 1 0 stop'//achar(10))
        end do
        call gather_calibration([FOLDER//'l1_days ', FOLDER//'l1_soe_1', FOLDER//'l1_soe_2'], setup_said(), '', '', none, &
                                'model', calibration, failure)
        call check_fails(error, failure, '2 manoeuvres ... 2020-02-01T03:01 (1 spans) ... 2020-02-04T03:01 (1 spans) ... --day')
        ! A span outside of the data is no span
        call gather_calibration([FOLDER//'l1_days'], setup_said(), '', '', reshape([0.0_dp, 60.0_dp], [2, 1]), 'model', &
                                calibration, failure)
        call check_fails(error, failure, '1 of 1 spans of the command line lie outside of the data')
        ! Days that follow one another: the next one has no manoeuvre, which is said with where there is one.
        call copy_day(path, FOLDER//'l1_days', '2020-02-05', -1e4_dp, start_of(0) - 10, 4*86400)
        call gather_calibration([FOLDER//'l1_days'], setup_said(), '', '', none, 'model', calibration, failure, '2020-02-05')
        call check_fails(error, failure, 'no manoeuvre found on 2020-02-05, but at 2020-02-04T03:01')
    end subroutine test_several_days

    !> The same through the interfaces of C and Fortran 77.
    subroutine check_day_from_c(error)
        type(error_type), allocatable, intent(inout) :: error
        character(*), parameter :: DAYS = FOLDER//'l1_days'//c_null_char, SETUP = FOLDER//'l1_setup.nml'//c_null_char
        type(error_struct) :: failure
        integer(c_intptr_t) :: first, last
        integer(c_int) :: status
        real(dp) :: d(3), covariance(3, 3), gain(3), delay(2)
        integer :: flag(2), istat
        character(80) :: message

        call make_setup()
        status = gracecg_level1_estimate(DAYS, SETUP, n_spans=0_c_size_t, offset=first, &
                                         error=failure)
        call check(error, status /= 0, 'without a day')
        status = gracecg_level1_estimate(DAYS, SETUP, day='2020-02-01'//c_null_char, n_spans=0_c_size_t, offset=first, &
                                         error=failure)
        call check(error, status, 0, 'the first day')
        status = gracecg_level1_estimate(DAYS, SETUP, day='2020-02-04'//c_null_char, n_spans=0_c_size_t, offset=last, &
                                         error=failure)
        call check(error, status, 0, 'the last day')
        call check(error, abs(sum(item(last, 'time', 1)) - sum(item(first, 'time', 1)) - 3*86400) < 1, 'three days apart')
        call gcl1dy(FOLDER//'l1_days', FOLDER//'l1_setup.nml', ' ', '2020-02-04', d, covariance, gain, delay, flag, istat, &
                    message)
        call check(error, istat == 0 .and. all(abs(d - item(last, 'offset', 3)) <= 0) .and. &
                   all(abs(gain - item(last, 'gain', 3)) <= 0), 'Fortran 77')
        status = gracecg_free(first)
        status = gracecg_free(last)
        ! half of the inertia: there is an estimate, not to be used
        call make_file('l1_half.nml', '&mass_properties mass = 580, moments_of_inertia = 35, 172, 194 /'//achar(10)//'&level1 /')
        status = gracecg_level1_estimate(DAYS, FOLDER//'l1_half.nml'//c_null_char, day='2020-02-01'//c_null_char, &
                                         n_spans=0_c_size_t, offset=first, error=failure)
        call check(error, status == 8 .and. first /= 0, 'flag 2: '//message_text(failure))
        if (.not. allocated(error)) call check(error, nint(sum(item(first, 'flag', 1))), 2)
        status = gracecg_free(first)
    end subroutine check_day_from_c

    !> A span longer than 900 s is left out with the reason; the others are used.
    subroutine test_longest_span(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_calibration_t) :: calibration
        type(error_t), allocatable :: failure
        character(:), allocatable :: path

        call write_day('l1_long', flaws_t(spans=2), path)
        call gather_calibration([path], setup_said(), '', '', reshape([EPOCH + start_of(0), DURATION, EPOCH + start_of(1) - 850, &
                                                                     901.0_dp], [2, 2]), 'model', calibration, failure)
        if (failed(error, failure)) return
        call check(error, calibration%spans(1)%used .and. .not. calibration%spans(2)%used, 'which are used')
        call check(error, trim(calibration%spans(2)%reason), 'longer than 900 s: give its sub-manoeuvres')
        ! One of 900 s is left out too, but because the files have only a part of it.
        call gather_calibration([path], setup_said(), '', '', reshape([EPOCH + start_of(1) - 850, 900.0_dp], [2, 1]), 'model', &
                                calibration, failure)
        if (failed(error, failure)) return
        call check(error, trim(calibration%spans(1)%reason), 'a gap in the orbit')
    end subroutine test_longest_span

    !> Spans found in currents: sines, not slow drifts or noise.
    subroutine test_spans(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 800
        real(dp) :: times(N), currents(3, N)
        real(dp), allocatable :: spans(:, :)
        integer :: i

        times = [(0.0833_dp + 0.5_dp*i, i=1, N)]
        currents(1, :) = 6*sin(times/80)
        currents(2, :) = 0
        currents(3, :) = -3
        call find_spans(times, currents, level1_setup_t(), spans)
        if (unmet(error, size(spans, 2), 0, 'science mode')) return
        where (times >= 100 .and. times <= 160) currents(1, :) = 90*sin(TWO_PI*(times - 100)/12)
        where (times >= 250 .and. times <= 310) currents(2, :) = sign(60.0_dp, sin(TWO_PI*(times - 250)/10))
        call find_spans(times, currents, level1_setup_t(sine_share=0.8_dp), spans)
        if (unmet(error, size(spans, 2), 2, 'two spans')) return
        call check(error, all(abs(spans - reshape([100, 160, 250, 310], [2, 2])) < 1.1_dp), 'begin and end')
        currents(2, :) = 30*sin(times**2/7)*cos(times**2/3)     ! irregular
        call find_spans(times, currents, level1_setup_t(), spans)
        call check(error, size(spans, 2) == 0, 'what no line explains is no manoeuvre')
    end subroutine test_spans

    !> Events of a file: of both satellites or one, deleted lines, and what is no event.
    subroutine test_events(error)
        type(error_type), allocatable, intent(out) :: error
        character(1), parameter :: LF = achar(10)
        type(level1_event_t), allocatable :: events(:)
        type(error_t), allocatable :: failure
        real(dp), allocatable :: spans(:, :)

        call make_file('soe_good.txt', '100 GRACEC CMCAL 1 1 begins'//LF//'160 GRACEX CMCAL 1 0 ends'//LF// &
                       'x 170 GRACEC CMCAL 1 1 deleted'//LF//LF//'180 GRACED CMCAL 1 1'//LF//'200 GRACEC UNKNOWN 0 what'//LF// &
                       '# not in order of time'//LF//'400.5 GRACEC CMCAL 1 0'//LF//'300 GRACEC CMCAL 1 2'//LF// &
                       '500 GRACEC VCM 3 1e-4 -2e-4 3e-4 text'//LF)
        call read_events(FOLDER//'soe_good.txt', events, failure)
        if (failed(error, failure)) return
        call manoeuvre_spans(events, 'C', spans)
        if (unmet(error, size(spans, 2), 2, 'spans')) return
        call check(error, maxval(abs(spans - reshape([100.0_dp, 160.0_dp, 300.0_dp, 400.5_dp], [2, 2]))) <= 0, 'times')
        if (unmet(error, maxval(abs(events(size(events))%values - [1e-4_dp, -2e-4_dp, 3e-4_dp])) <= 0, 'values')) return
        call make_file('soe_bad.txt', '100 GRACEC CMCAL 2 1'//LF)
        call read_events(FOLDER//'soe_bad.txt', events, failure)
        call check_fails(error, failure, 'soe_bad.txt:1')
    end subroutine test_events
end module test_level1_days
