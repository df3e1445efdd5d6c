!> The C interface: the offset from Level-1 data. Documented in include/gracecg_level1.h.
module gracecg_level1_c_estimate
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int32_t, c_size_t
    use gracecg, only: dp, error_t
    use gracecg_level1, only: level1_setup_t, read_level1_setup, level1_calibration_t, gather_calibration, &
        level1_estimate_t, estimate_level1, LEVEL1_SOURCES
    use gracecg_base_error, only: fail_unknown_name
    use gracecg_level1_calibration, only: middle_of
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, LONGEST_NAME, start, pass_on, need, check_count, &
        check_finite, check_result, fortran_text, give_text
    implicit none
    private
    public :: c_level1_offset_t, c_estimate_level1, c_estimate_level1_day

    integer, parameter :: MOST_SPANS = 1000

    !> gracecg_level1_offset
    type, bind(c) :: c_level1_offset_t
        real(c_double) :: offset(3)                 !! d, m, SRF
        real(c_double) :: covariance(3, 3)          !! m^2
        real(c_double) :: time                      !! Middle of the manoeuvre, GPS s past 2000-01-01 12:00
        real(c_double) :: gain(3)                   !! Of the rods, A m^2/mA
        real(c_double) :: gain_sigma(3)             !! A m^2/mA
        real(c_double) :: torque_delay              !! s
        real(c_double) :: torque_delay_sigma        !! s
        real(c_double) :: accelerometer_delay       !! s
        real(c_double) :: accelerometer_delay_sigma !! s; 0: not estimated
        real(c_double) :: condition                 !! With leakage, without its a-priori sigma; at most DBL_MAX
        real(c_double) :: residual_rms(3)           !! In the band, m/s^2
        real(c_double) :: chi_square                !! Of the spans about the offset
        integer(c_int32_t) :: degrees               !! Of freedom of chi_square
        integer(c_int32_t) :: spans                 !! That are used
        integer(c_int32_t) :: samples               !! Of the accelerometer, that are used
        integer(c_int32_t) :: leakage               !! 0 left out, 1 by its a-priori sigma, 2 estimated
        integer(c_int32_t) :: flag                  !! 0 good, 1 with care, 2 not to be used
        integer(c_int32_t) :: reserved              !! 0
    end type c_level1_offset_t

contains

    !> gracecg_estimate_level1
    function c_estimate_level1(folder, setup, satellite, n_spans, spans, source, c_offset, text, size, length, error) &
        result(status) bind(c, name='gracecg_estimate_level1')
        character(kind=c_char), intent(in), optional :: folder(*), setup(*), satellite(*)
        integer(c_size_t), intent(in), value :: n_spans
        real(c_double), intent(in), optional :: spans(2, *)
        character(kind=c_char), intent(in), optional :: source(*)
        type(c_level1_offset_t), intent(inout), optional :: c_offset
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: size
        integer(c_size_t), intent(inout), optional :: length
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        status = c_estimate_level1_day(folder, setup, satellite, n_spans=n_spans, spans=spans, source=source, &
                                       c_offset=c_offset, text=text, size=size, length=length, error=error)
    end function c_estimate_level1

    !> gracecg_estimate_level1_day
    function c_estimate_level1_day(folder, setup, satellite, day, n_spans, spans, source, c_offset, text, size, length, &
                                   error) result(status) bind(c, name='gracecg_estimate_level1_day')
        character(kind=c_char), intent(in), optional :: folder(*), setup(*), satellite(*), day(*)
        integer(c_size_t), intent(in), value :: n_spans
        real(c_double), intent(in), optional :: spans(2, *)
        character(kind=c_char), intent(in), optional :: source(*)
        type(c_level1_offset_t), intent(inout), optional :: c_offset
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: size
        integer(c_size_t), intent(inout), optional :: length
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(level1_setup_t) :: settings
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(error_t), allocatable :: failure
        character(:), allocatable :: folder_name, setup_name, satellite_name, day_name, source_name, words
        real(dp), allocatable :: given(:, :)

        call start(status, error)
        call need(present(c_offset), 'offset', status, error)
        call fortran_text(folder, LONGEST_NAME, 'folder', folder_name, status, error)
        call fortran_text(setup, LONGEST_NAME, 'setup', setup_name, status, error)
        satellite_name = ''
        if (present(satellite)) call fortran_text(satellite, 1, 'satellite', satellite_name, status, error)
        day_name = ''
        if (present(day)) call fortran_text(day, LONGEST_NAME, 'day', day_name, status, error)
        source_name = LEVEL1_SOURCES(1)
        if (present(source)) call fortran_text(source, LONGEST_NAME, 'source', source_name, status, error)
        call check_count(n_spans, 'the number of spans', status, error, MOST_SPANS)
        if (n_spans > 0) call need(present(spans), 'spans', status, error)
        if (status /= STATUS_OK) return
        if (source_name == '') source_name = LEVEL1_SOURCES(1)
        if (all(LEVEL1_SOURCES /= source_name)) &
            call fail_unknown_name(failure, 'source of angular acceleration', source_name, LEVEL1_SOURCES)
        call pass_on(failure, status, error)
        allocate (given(2, n_spans))
        if (n_spans > 0) then
            given = spans(:, :n_spans)
            call check_finite(given, 2*n_spans, 'spans', status, error)
        end if
        if (status == STATUS_OK) call read_level1_setup(setup_name, settings, failure)
        if (status == STATUS_OK .and. .not. allocated(failure)) &
            call gather_calibration(folder_name, settings, satellite_name, '', given, 'model', calibration, failure, &
                                    day_name)
        if (status == STATUS_OK .and. .not. allocated(failure)) &
            call estimate_level1(calibration, settings, [source_name], 'estimate', estimate, failure)
        call pass_on(failure, status, error)
        if (status /= STATUS_OK) return
        call fill(calibration, settings, estimate, c_offset)
        call check_result([c_offset%offset, [c_offset%covariance], c_offset%gain, c_offset%gain_sigma], 'the estimate', &
                          status, error)
        call tell(estimate, words)
        if (present(text) .or. present(length)) call give_text(words, text, size, length, status, error)
    end function c_estimate_level1_day

    subroutine fill(calibration, settings, estimate, c_offset)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: settings
        type(level1_estimate_t), intent(in) :: estimate
        type(c_level1_offset_t), intent(inout) :: c_offset

        character(10), parameter :: LEAKAGE(0:2) = [character(10) :: 'none', 'a priori', 'estimated']

        associate (first => estimate%solutions(1), rods => estimate%rods)
            c_offset%offset = first%offset
            c_offset%covariance = first%covariance
            c_offset%time = middle_of(calibration)
            c_offset%gain = rods%gain*settings%rod_gain*settings%rod_sign
            c_offset%gain_sigma = rods%gain_sigma*settings%rod_gain
            c_offset%torque_delay = rods%delay
            c_offset%torque_delay_sigma = rods%delay_sigma
            c_offset%accelerometer_delay = estimate%accelerometer_delay
            c_offset%accelerometer_delay_sigma = estimate%accelerometer_delay_sigma
            c_offset%condition = first%condition
            c_offset%residual_rms = first%rms
            c_offset%chi_square = first%chi_square
            c_offset%degrees = first%degrees
            c_offset%spans = first%spans
            c_offset%samples = first%samples
            c_offset%leakage = findloc(LEAKAGE, first%leakage, 1) - 1
            c_offset%flag = first%flag
            c_offset%reserved = 0
        end associate
    end subroutine fill

    !> Why the flag is not 0, and what is wrong, a line each.
    subroutine tell(estimate, text)
        type(level1_estimate_t), intent(in) :: estimate
        character(:), allocatable, intent(out) :: text

        integer :: i

        text = trim(estimate%solutions(1)%reason)
        do i = 1, size(estimate%findings)
            text = text//new_line('a')//estimate%findings(i)%text
        end do
    end subroutine tell
end module gracecg_level1_c_estimate
