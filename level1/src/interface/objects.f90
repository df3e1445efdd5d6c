!> The C interface: Level-1 data of GRACE and GRACE-FO. Documented in include/gracecg_level1.h.
module gracecg_level1_objects
    use gracecg, only: dp, error_t
    use gracecg_level1, only: level1_records_t, read_level1, level1_setup_t, read_level1_setup, level1_calibration_t, &
        gather_calibration, level1_estimate_t, estimate_level1
    use gracecg_level1_calibration, only: middle_of
    use gracecg_interface_handles, only: object_t
    use gracecg_interface_items, only: items_t, lines_of
    use gracecg_interface_outcome, only: outcome_t, STATUS_BAD_VALUE, STATUS_NOT_USABLE
    implicit none
    private
    public :: level1_object_t, level1_offset_object_t, level1_open, level1_estimate

    !> The records of a file behind a handle.
    type, extends(object_t) :: level1_object_t
        type(level1_records_t) :: records       !! In order of time
    contains
        procedure :: tell => tell_records       !! Puts its items
    end type level1_object_t

    !> An estimate behind a handle.
    type, extends(object_t) :: level1_offset_object_t
        type(level1_estimate_t) :: estimate     !! Its first solution is the result
        real(dp) :: time = 0                    !! Middle of the manoeuvre, GPS s past 2000-01-01 12:00:00
        real(dp) :: rod_gain(3) = 0             !! Nominal, with its sign, A m^2/mA
    contains
        procedure :: tell => tell_estimate      !! Puts its items
    end type level1_offset_object_t

contains

    !> The records of a Level-1 file in order of time, each epoch once: text or binary.
    subroutine level1_open(path, span, made, outcome)
        character(*), intent(in) :: path                !! Of the file
        real(dp), intent(in), optional :: span(2)       !! Of time tags, s past 2000-01-01 12:00:00
        type(level1_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure
        real(dp), allocatable :: spans(:, :)        ! not allocated: all

        if (present(span)) then
            spans = reshape(span, [2, 1])
            if (span(2) < span(1)) call outcome%refuse(STATUS_BAD_VALUE, 'span: its end lies before its begin')
        end if
        if (.not. outcome%good()) return
        call read_level1(path, made%records, failure, spans=spans)
        call outcome%take(failure)
    end subroutine level1_open

    subroutine tell_records(self, items)
        class(level1_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        character(:), allocatable :: text
        integer :: i

        associate (records => self%records)
            call items%put('time_seconds', real(records%seconds(:records%count), dp))
            call items%put('time_fraction', records%fraction(:records%count))
            call items%say('about', trim(records%layout%product//' '//records%satellite//' '//records%time_ref))
            text = ''
            do i = 1, size(records%fields)
                text = text//trim(records%fields(i))//new_line('a')
            end do
            call items%say('fields', text)
            call lines_of(records%warnings, text)
            call items%say('warnings', text)
            do i = 1, size(records%fields)
                call items%put(trim(records%fields(i)), records%values(:records%count, i))
            end do
        end associate
    end subroutine tell_records

    !> The offset of a calibration manoeuvre from the Level-1 files in a folder, as `gracecg level1 estimate` finds it.
    subroutine level1_estimate(folder, setup, satellite, day, n_spans, spans, made, outcome)
        character(*), intent(in) :: folder, setup           !! Of the files; path of a namelist
        character(*), intent(in) :: satellite, day          !! Each may be empty: the first; of all files
        integer, intent(in) :: n_spans                      !! 0: those of the folder
        real(dp), intent(in), optional :: spans(2, n_spans) !! Start (GPS s past 2000-01-01 12:00:00), duration (s)
        type(level1_offset_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(level1_setup_t) :: settings
        type(level1_calibration_t) :: calibration
        type(error_t), allocatable :: failure
        real(dp) :: given(2, n_spans)

        given = 0
        if (present(spans)) given = spans
        if (len(satellite) > 1) call outcome%refuse(STATUS_BAD_VALUE, 'satellite is longer than 1 byte')
        call read_level1_setup(setup, settings, failure)
        call outcome%take(failure)
        if (.not. outcome%good()) return
        call gather_calibration([folder], settings, satellite, '', given, 'model', calibration, failure, day)
        if (.not. allocated(failure)) &
            call estimate_level1(calibration, settings, 'estimate', made%estimate, failure)
        call outcome%take(failure)
        if (.not. outcome%good()) return
        made%time = middle_of(calibration)
        made%rod_gain = settings%rod_gain*settings%rod_sign
        associate (first => made%estimate%solutions(1), rods => made%estimate%rods)
            if (.not. all(abs([first%offset, [first%covariance], rods%gain, rods%gain_sigma]) <= huge(1.0_dp))) &
                call outcome%refuse(STATUS_BAD_VALUE, 'the estimate would be NaN or infinite')
        end associate
        if (made%estimate%flag > 1) call outcome%refuse(STATUS_NOT_USABLE, made%estimate%action%text)
    end subroutine level1_estimate

    subroutine tell_estimate(self, items)
        class(level1_offset_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        character(10), parameter :: LEAKAGE(0:2) = [character(10) :: 'none', 'a priori', 'estimated']
        character(:), allocatable :: text
        integer :: i

        call items%put('time', self%time)
        associate (first => self%estimate%solutions(1), rods => self%estimate%rods)
            call items%put('offset', first%offset)
            call items%put('covariance', first%covariance)
            call items%put('gain', rods%gain*self%rod_gain)
            call items%put('gain_sigma', rods%gain_sigma*abs(self%rod_gain))
            call items%put('torque_delay', rods%delay)
            call items%put('torque_delay_sigma', rods%delay_sigma)
            call items%put('accelerometer_delay', self%estimate%accelerometer_delay)
            call items%put('accelerometer_delay_sigma', self%estimate%accelerometer_delay_sigma)
            call items%put('condition', first%condition)
            call items%put('residual_rms', first%rms)
            call items%put('chi_square', first%chi_square)
            call items%put('degrees', real(first%degrees, dp))
            call items%put('spans', real(first%spans, dp))
            call items%put('samples', real(first%samples, dp))
            call items%put('leakage', real(findloc(LEAKAGE, first%leakage, 1) - 1, dp))
            call items%put('flag', real(first%flag, dp))
            text = trim(first%reason)
        end associate
        do i = 1, size(self%estimate%findings)
            text = text//new_line('a')//self%estimate%findings(i)%text
        end do
        call items%say('text', text)
    end subroutine tell_estimate
end module gracecg_level1_objects
