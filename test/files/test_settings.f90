!> Settings: one description, written and read; units, ranges, and a message for every mistake.
module test_settings
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, message_of
    use gracecg_files_settings
    use gracecg_files_file, only: remove_file
    use fixture, only: FOLDER, make_file, check_fails, check_passes
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_settings

    character(*), parameter :: LF = achar(10), PLACE = FOLDER//'settings.nml'
    integer, parameter :: W = 60        !! Length of the parts of a message

    !> A record with a setting of every kind.
    type :: record_t
        real(dp) :: mass = 420
        real(dp) :: bias(3) = [50e-9_dp, -30e-9_dp, 25e-9_dp]       !! T
        real(dp) :: angle = 0.3_dp                                  !! rad
        integer :: stars = 20
        logical :: limited = .true.
        character(8) :: model = 'dtm77'
        integer :: rods = 0
        real(dp) :: amplitude(3) = 0
    end type record_t

    real(dp), parameter :: DEGREE = acos(-1.0_dp)/180

contains

    subroutine collect_settings(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('written-and-read', test_round_trip), &
                    new_unittest('units-of-the-file', test_units), &
                    new_unittest('defaults-stay', test_defaults), &
                    new_unittest('groups-of-one-name', test_groups), &
                    new_unittest('missing-required-key', test_missing), &
                    new_unittest('unknown-key', test_unknown), &
                    new_unittest('out-of-range', test_range), &
                    new_unittest('wrong-types', test_types), &
                    new_unittest('text-too-long', test_long_text), &
                    new_unittest('reject', test_reject), &
                    new_unittest('first-failure-counts', test_first_failure), &
                    new_unittest('no-file', test_no_file), &
                    new_unittest('nan-is-not-written', test_nan)]
    end subroutine collect_settings

    subroutine describe(settings, record)
        class(settings_t), intent(inout) :: settings
        type(record_t), intent(inout) :: record
        integer :: i

        call settings%group('satellite', 'The satellite')
        call settings%real_value('mass', record%mass, 1.0_dp, 1e4_dp, 'kg', unit='kg', &
                                 required=.true.)
        if (record%mass == 13) call settings%reject('mass', 'brings bad luck')
        call settings%real_values('bias_nt', record%bias, -1e5_dp, 1e5_dp, 'nT', 1e-9_dp, 'nT')
        call settings%real_value('angle_deg', record%angle, -180.0_dp, 180.0_dp, 'deg', DEGREE, &
                                 'deg')
        call settings%integer_value('stars', record%stars, 2, 70, 'of a frame')
        call settings%logical_value('limited', record%limited, 'saturates')
        call settings%text_value('model', record%model, 'of density', &
                                 [character(8) :: 'dtm77', 'none'])
        call settings%end_group()
        call settings%count('rod', record%rods)
        do i = 1, record%rods
            call settings%group('rod', 'A rod', i)
            call settings%real_value('amplitude', record%amplitude(i), -30.0_dp, 30.0_dp, 'A m^2', &
                                     unit='A m^2', required=.true.)
            call settings%end_group()
        end do
    end subroutine describe

    !> The text of a record.
    subroutine write_text(record, text, failure)
        type(record_t), intent(in) :: record
        character(:), allocatable, intent(out) :: text
        type(error_t), allocatable, intent(out) :: failure
        type(settings_t) :: settings
        type(record_t) :: copy

        copy = record
        call describe(settings, copy)
        call settings%to_text(text, failure)
    end subroutine write_text

    !> Reads a text as a file.
    subroutine read_text(error, text, record, failure)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: text
        type(record_t), intent(out) :: record
        type(error_t), allocatable, intent(out) :: failure
        type(settings_t) :: settings

        call make_file(error, 'settings.nml', text)
        if (allocated(error)) return
        call settings%open(PLACE, failure)
        if (.not. allocated(failure)) then
            call describe(settings, record)
            call settings%finish(failure)
        end if
        call remove_file(PLACE)
    end subroutine read_text

    !> Reading this text must fail with a message that has every one of the parts.
    subroutine refused(error, text, parts)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: text, parts(:)
        type(record_t) :: record
        type(error_t), allocatable :: failure

        call read_text(error, text, record, failure)
        if (allocated(error)) return
        call check_fails(error, message_of(failure), parts)
    end subroutine refused

    subroutine test_round_trip(error)
        type(error_type), allocatable, intent(out) :: error
        type(record_t) :: record, again
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, text_again

        record = record_t(432.123456789012345_dp, [1e-9_dp/3, -2e-8_dp, 0.0_dp], -1.234567_dp, 33, &
                          .false., 'none', 2, [30.0_dp, -0.1_dp, 0.0_dp])
        call write_text(record, text, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call read_text(error, text, again, failure)
        if (allocated(error)) return
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, again%mass == record%mass .and. again%stars == 33 .and. &
                   .not. again%limited &
                   .and. again%model == 'none' .and. again%rods == 2 .and. &
                   all(again%amplitude == record%amplitude))
        if (allocated(error)) return
        call check(error, maxval(abs(again%bias - record%bias)), 0.0_dp, thr=1e-22_dp)
        if (allocated(error)) return
        call check(error, again%angle, record%angle, thr=1e-14_dp)
        if (allocated(error)) return
        call write_text(again, text_again, failure)
        call check(error, text_again, text)
    end subroutine test_round_trip

    !> 50 nT stand as 50 in the file, not as 50.00000000000001.
    subroutine test_units(error)
        type(error_type), allocatable, intent(out) :: error
        type(record_t) :: record
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        record%angle = 45*DEGREE
        call write_text(record, text, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, index(text, 'bias_nt = 50, -30, 25 ') > 0 .and. &
                   index(text, 'angle_deg = 45 ') > 0, &
                   text)
        if (allocated(error)) return
        call read_text(error, '&satellite mass = 1 bias_nt = 7 8 9 angle_deg = 180 /', record, &
                       failure)
        if (allocated(error)) return
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, maxval(abs(record%bias - [7e-9_dp, 8e-9_dp, 9e-9_dp])), 0.0_dp, &
                   thr=1e-23_dp)
        if (allocated(error)) return
        call check(error, record%angle, acos(-1.0_dp), thr=1e-15_dp)
    end subroutine test_units

    subroutine test_defaults(error)
        type(error_type), allocatable, intent(out) :: error
        type(record_t) :: record
        type(error_t), allocatable :: failure

        call read_text(error, '&satellite mass = 99 /', record, failure)
        if (allocated(error)) return
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, record%mass == 99 .and. all(record%bias == [50e-9_dp, -30e-9_dp, &
                   25e-9_dp]) &
                   .and. record%angle == 0.3_dp .and. record%stars == 20 .and. &
                       record%limited .and. &
                   record%model == 'dtm77' .and. record%rods == 0)
    end subroutine test_defaults

    subroutine test_groups(error)
        type(error_type), allocatable, intent(out) :: error
        type(record_t) :: record
        type(error_t), allocatable :: failure

        call read_text(error, '&rod amplitude = 1 /'//LF//'&satellite mass = 99 /'//LF// &
                       '&rod amplitude = 2 / &rod amplitude = 3 /', record, failure)
        if (allocated(error)) return
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, record%rods == 3 .and. all(record%amplitude == [1, 2, 3]))
        if (allocated(error)) return
        call refused(error, '&satellite mass = 99 / &rod amplitude = 2 /'//LF// &
                     '&rod amplitude = 31 /', &
                     [character(W) :: PLACE//':2', 'amplitude', '31', '-30 to 30', 'A m^2'])
    end subroutine test_groups

    subroutine test_missing(error)
        type(error_type), allocatable, intent(out) :: error

        call refused(error, '&satellite'//LF//'stars = 3 /', &
                     [character(W) :: PLACE//':1', 'mass', 'missing', '1 to 10000 kg'])
        if (allocated(error)) return
        call refused(error, '&rod amplitude = 3 /', [character(W) :: PLACE, 'satellite', 'mass'])
    end subroutine test_missing

    !> With the nearest known key, also of those that the file does not have.
    subroutine test_unknown(error)
        type(error_type), allocatable, intent(out) :: error

        call refused(error, '&satellite mass = 2'//LF//'  starz = 3 /', &
                     [character(W) :: PLACE//':2', 'starz', 'did you mean "stars"'])
        if (allocated(error)) return
        call refused(error, '&satellite mass = 2'//LF//'  bais_nt = 3 4 5 /', &
                     [character(W) :: PLACE//':2', 'bais_nt', 'did you mean "bias_nt"'])
        if (allocated(error)) return
        call refused(error, '&satellite mass = 2 /'//LF//'&rodd amplitude = 3 /', &
                     [character(W) :: PLACE//':2', 'rodd', 'did you mean'])
    end subroutine test_unknown

    !> Limits are in the file's unit.
    subroutine test_range(error)
        type(error_type), allocatable, intent(out) :: error

        call refused(error, '&satellite'//LF//'mass = 0.5 /', &
                     [character(W) :: PLACE//':2', 'mass', '0.5', '1 to 10000 kg'])
        if (allocated(error)) return
        call refused(error, '&satellite mass = 2'//LF//'angle_deg = 181 /', &
                     [character(W) :: PLACE//':2', 'angle_deg', '181', '-180 to 180 deg'])
        if (allocated(error)) return
        call refused(error, '&satellite mass = 2 bias_nt = 1'//LF//' 2e5 3 /', &
                     [character(W) :: PLACE//':2', 'bias_nt', '2e5', '-100000 to 100000 nT'])
        if (allocated(error)) return
        call refused(error, '&satellite mass = 2 stars = 71 /', &
                     [character(W) :: PLACE//':1', 'stars', '71', '2 to 70'])
        if (allocated(error)) return
        call refused(error, '&satellite mass = NaN /', &
                     [character(W) :: 'mass', 'not a finite number'])
    end subroutine test_range

    subroutine test_types(error)
        type(error_type), allocatable, intent(out) :: error

        call refused(error, '&satellite mass = ''heavy'' /', &
                     [character(W) :: 'mass', 'heavy', 'number'])
        if (allocated(error)) return
        call refused(error, '&satellite mass = 2 bias_nt = 1 2 /', [character(W) :: 'bias_nt', '3'])
        if (allocated(error)) return
        call refused(error, '&satellite mass = 2 stars = 3.5 /', &
                     [character(W) :: 'stars', '3.5', 'integer'])
        if (allocated(error)) return
        call refused(error, '&satellite mass = 2 limited = 3 /', &
                     [character(W) :: 'limited', 'logical'])
        if (allocated(error)) return
        call refused(error, '&satellite mass = 2 model = ''dtm78'' /', &
                     [character(W) :: 'model', 'dtm78', 'dtm77, none', 'did you mean "dtm77"'])
    end subroutine test_types

    !> A text that does not fit is refused, not cut.
    subroutine test_long_text(error)
        type(error_type), allocatable, intent(out) :: error
        type(settings_t) :: settings
        type(error_t), allocatable :: failure
        character(4) :: name

        call make_file(error, 'settings.nml', '&satellite'//LF//'name = ''tango'' /')
        if (allocated(error)) return
        call settings%open(PLACE, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        name = 'none'
        call settings%group('satellite', '')
        call settings%text_value('name', name, 'of the satellite')
        call settings%finish(failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: PLACE//':2', 'name', 'more than 4 characters'])
        if (allocated(error)) return
        call check(error, name, 'none')
        call remove_file(PLACE)
    end subroutine test_long_text

    !> A refusal of the caller's own shows the place; a writer takes no notice.
    subroutine test_reject(error)
        type(error_type), allocatable, intent(out) :: error
        type(record_t) :: record
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call refused(error, '&satellite'//LF//LF//'mass = 13 /', &
                     [character(W) :: PLACE//':3', 'mass', 'brings bad luck'])
        if (allocated(error)) return
        record%mass = 13
        call write_text(record, text, failure)
        call check_passes(error, message_of(failure))
    end subroutine test_reject

    !> Of two mistakes the first in the description is told, whatever its place in the file; a wrong
    !> value comes before an unknown key.
    subroutine test_first_failure(error)
        type(error_type), allocatable, intent(out) :: error

        call refused(error, '&satellite stars = 99'//LF//'mass = 0'//LF//'foo = 1 /', &
                     [character(W) :: PLACE//':2', 'mass'])
    end subroutine test_first_failure

    subroutine test_no_file(error)
        type(error_type), allocatable, intent(out) :: error
        type(settings_t) :: settings
        type(error_t), allocatable :: failure

        call settings%open(FOLDER//'there-is-none.nml', failure)
        call check_fails(error, message_of(failure), [character(W) :: 'there-is-none.nml'])
    end subroutine test_no_file

    subroutine test_nan(error)
        type(error_type), allocatable, intent(out) :: error
        type(record_t) :: record
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        record%bias(2) = ieee_value(1.0_dp, ieee_quiet_nan)
        call write_text(record, text, failure)
        call check_fails(error, message_of(failure), [character(W) :: 'bias_nt'])
    end subroutine test_nan
end module test_settings
