!> The C interface: version, names, time. Documented in include/gracecg.h.
module gracecg_interface_c_general
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int32_t, c_loc, c_null_char, &
        c_null_ptr, c_ptr, c_size_t
    use gracecg, only: dp, error_t, utc_t, parse_utc, seconds_between, gmst_1982, rotation_z, ARCSECOND, &
        earth_parameters_t, earth_orientation_t, new_earth_orientation, read_earth_parameters, &
        LIBRARY_VERSION, ESTIMATOR_NAMES, CASE_NAMES
    use gracecg_interface_c_support, only: c_error_t, c_utc_t, STATUS_OK, STATUS_BAD_VALUE, LONGEST_NAME, start, &
        raise, pass_on, need, check_count, check_finite, fortran_text, time_of, later_time
    implicit none
    private
    public :: c_version, c_status_text, c_algorithm_count, c_algorithm_name, c_case_count, c_case_name
    public :: c_utc_parse, c_utc_add, c_utc_difference, c_sidereal_angle, c_earth_fixed, c_earth_parameters, c_earth_orientation

    integer, parameter :: NAME_SIZE = 32            !! Bytes of a constant text with its closing zero
    integer(c_int), parameter :: LAST_STATUS = 7
    character(NAME_SIZE), parameter :: STATUS_TEXTS(0:LAST_STATUS + 1) = [character(NAME_SIZE) :: &
        'success'//c_null_char, 'a needed argument is NULL'//c_null_char, &
        'not a valid handle'//c_null_char, 'wrong size'//c_null_char, &
        'a value is not allowed'//c_null_char, 'the work failed'//c_null_char, &
        'not converged'//c_null_char, 'no memory'//c_null_char, 'unknown status'//c_null_char]
    integer :: k
    ! Constant texts that callers point to: never changed, so that threads may read them
    character(NAME_SIZE), save, target :: version_text = LIBRARY_VERSION//c_null_char
    character(NAME_SIZE), save, target :: status_names(0:LAST_STATUS + 1) = STATUS_TEXTS
    character(NAME_SIZE), save, target :: algorithm_names(size(ESTIMATOR_NAMES)) = &
        [(trim(ESTIMATOR_NAMES(k))//repeat(c_null_char, NAME_SIZE - len_trim(ESTIMATOR_NAMES(k))), &
          k=1, size(ESTIMATOR_NAMES))]
    character(NAME_SIZE), save, target :: builtin_cases(size(CASE_NAMES)) = &
        [(trim(CASE_NAMES(k))//repeat(c_null_char, NAME_SIZE - len_trim(CASE_NAMES(k))), &
          k=1, size(CASE_NAMES))]

contains

    !> gracecg_version
    function c_version() result(text) bind(c, name='gracecg_version')
        type(c_ptr) :: text

        text = c_loc(version_text)
    end function c_version

    !> gracecg_status_text
    function c_status_text(status) result(text) bind(c, name='gracecg_status_text')
        integer(c_int), intent(in), value :: status
        type(c_ptr) :: text

        text = c_loc(status_names(LAST_STATUS + 1))
        if (status >= 0 .and. status <= LAST_STATUS) text = c_loc(status_names(status))
    end function c_status_text

    !> gracecg_algorithm_count
    integer(c_int32_t) function c_algorithm_count() result(n) bind(c, name='gracecg_algorithm_count')
        n = size(algorithm_names)
    end function c_algorithm_count

    !> gracecg_algorithm_name
    function c_algorithm_name(index) result(text) bind(c, name='gracecg_algorithm_name')
        integer(c_int32_t), intent(in), value :: index      !! From 0
        type(c_ptr) :: text

        text = c_null_ptr
        if (index >= 0 .and. index < size(algorithm_names)) text = c_loc(algorithm_names(index + 1))
    end function c_algorithm_name

    !> gracecg_case_count
    integer(c_int32_t) function c_case_count() result(n) bind(c, name='gracecg_case_count')
        n = size(builtin_cases)
    end function c_case_count

    !> gracecg_case_name
    function c_case_name(index) result(text) bind(c, name='gracecg_case_name')
        integer(c_int32_t), intent(in), value :: index      !! From 0
        type(c_ptr) :: text

        text = c_null_ptr
        if (index >= 0 .and. index < size(builtin_cases)) text = c_loc(builtin_cases(index + 1))
    end function c_case_name

    !> gracecg_utc_parse
    function c_utc_parse(text, utc, error) result(status) bind(c, name='gracecg_utc_parse')
        character(kind=c_char), intent(in), optional :: text(*)
        type(c_utc_t), intent(inout), optional :: utc
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(error_t), allocatable :: failure
        type(utc_t) :: time
        character(:), allocatable :: word

        call start(status, error)
        call fortran_text(text, LONGEST_NAME, 'text', word, status, error)
        call need(present(utc), 'utc', status, error)
        if (status /= STATUS_OK) return
        call parse_utc(word, time, failure)
        call pass_on(failure, status, error, STATUS_BAD_VALUE)
        if (status == STATUS_OK) utc = c_utc_t(time%mjd, time%seconds)
    end function c_utc_parse

    !> gracecg_utc_add
    function c_utc_add(utc, seconds, later, error) result(status) bind(c, name='gracecg_utc_add')
        type(c_utc_t), intent(in), optional :: utc
        real(c_double), intent(in), value :: seconds
        type(c_utc_t), intent(inout), optional :: later
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(utc_t) :: before, after

        call start(status, error)
        call need(present(later), 'later', status, error)
        call time_of(utc, 'utc', before, status, error)
        call later_time(before, seconds, after, status, error)
        if (status == STATUS_OK) later = c_utc_t(after%mjd, after%seconds)
    end function c_utc_add

    !> gracecg_utc_difference
    function c_utc_difference(first, finish, seconds, error) result(status) &
        bind(c, name='gracecg_utc_difference')
        type(c_utc_t), intent(in), optional :: first, finish
        real(c_double), intent(inout), optional :: seconds
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(utc_t) :: from, to

        call start(status, error)
        call need(present(seconds), 'seconds', status, error)
        call time_of(first, 'start', from, status, error)
        call time_of(finish, 'finish', to, status, error)
        if (status == STATUS_OK) seconds = seconds_between(from, to)
    end function c_utc_difference

    !> gracecg_sidereal_angle
    function c_sidereal_angle(utc, ut1_minus_utc, angle, error) result(status) &
        bind(c, name='gracecg_sidereal_angle')
        type(c_utc_t), intent(in), optional :: utc
        real(c_double), intent(in), value :: ut1_minus_utc
        real(c_double), intent(inout), optional :: angle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        real(dp), parameter :: GREATEST = 1     ! UTC is kept within 0.9 s of UT1
        type(utc_t) :: time

        call start(status, error)
        call need(present(angle), 'angle', status, error)
        call time_of(utc, 'utc', time, status, error)
        if (status /= STATUS_OK) return
        if (abs(ut1_minus_utc) <= GREATEST) then
            angle = gmst_1982(time, ut1_minus_utc)
        else
            call raise(STATUS_BAD_VALUE, 'ut1_minus_utc has to lie in -1 to 1 s', status, error)
        end if
    end function c_sidereal_angle

    !> gracecg_earth_fixed
    function c_earth_fixed(sidereal_angle, n, inertial, fixed, error) result(status) &
        bind(c, name='gracecg_earth_fixed')
        real(c_double), intent(in), value :: sidereal_angle
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: inertial(3, *)
        real(c_double), intent(inout), optional :: fixed(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        real(dp) :: rotation(3, 3), vector(3)
        integer(c_size_t) :: i

        call start(status, error)
        call check_count(n, 'n', status, error)
        call check_finite([sidereal_angle], 1_c_size_t, 'sidereal_angle', status, error)
        if (status /= STATUS_OK .or. n == 0) return
        call need(present(inertial), 'inertial', status, error)
        call need(present(fixed), 'fixed', status, error)
        if (status /= STATUS_OK) return
        call check_finite(inertial, 3*n, 'inertial', status, error)
        if (status /= STATUS_OK) return
        rotation = rotation_z(sidereal_angle)
        do i = 1, n
            vector = matmul(rotation, inertial(:, i))
            fixed(:, i) = vector
        end do
    end function c_earth_fixed

    !> gracecg_earth_parameters
    function c_earth_parameters(path, utc, ut1_minus_utc, pole, error) result(status) &
        bind(c, name='gracecg_earth_parameters')
        character(kind=c_char), intent(in), optional :: path(*)
        type(c_utc_t), intent(in), optional :: utc
        real(c_double), intent(inout), optional :: ut1_minus_utc, pole(2)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        character(:), allocatable :: name
        type(earth_parameters_t) :: parameters
        type(error_t), allocatable :: failure
        type(utc_t) :: time

        call start(status, error)
        call time_of(utc, 'utc', time, status, error)
        call fortran_text(path, LONGEST_NAME, 'path', name, status, error)
        if (status /= STATUS_OK) return
        call read_earth_parameters(name, time, parameters, failure)
        call pass_on(failure, status, error)
        if (status /= STATUS_OK) return
        if (present(ut1_minus_utc)) ut1_minus_utc = parameters%ut1_minus_utc
        if (present(pole)) pole = parameters%pole
    end function c_earth_parameters

    !> gracecg_earth_orientation
    function c_earth_orientation(utc, ut1_minus_utc, pole, seconds, rotation, error) result(status) &
        bind(c, name='gracecg_earth_orientation')
        type(c_utc_t), intent(in), optional :: utc
        real(c_double), intent(in), value :: ut1_minus_utc, seconds
        real(c_double), intent(in), optional :: pole(2)
        real(c_double), intent(inout), optional :: rotation(3, 3)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        real(dp), parameter :: GREATEST = 2, GREATEST_POLE = 2*ARCSECOND, LONGEST = 864000.0_dp
        type(earth_parameters_t) :: parameters
        type(earth_orientation_t) :: earth
        type(error_t), allocatable :: failure
        type(utc_t) :: time

        call start(status, error)
        call need(present(rotation), 'rotation', status, error)
        call time_of(utc, 'utc', time, status, error)
        if (status /= STATUS_OK) return
        parameters%ut1_minus_utc = ut1_minus_utc
        if (present(pole)) parameters%pole = pole
        if (.not. abs(ut1_minus_utc) <= GREATEST) then
            call raise(STATUS_BAD_VALUE, 'ut1_minus_utc has to lie in -2 to 2 s', status, error)
        else if (.not. all(abs(parameters%pole) <= GREATEST_POLE)) then
            call raise(STATUS_BAD_VALUE, 'the pole has to lie within 2 arcsec, in rad', status, error)
        else if (.not. abs(seconds) <= LONGEST) then
            call raise(STATUS_BAD_VALUE, 'seconds have to lie within ten days', status, error)
        end if
        if (status /= STATUS_OK) return
        call new_earth_orientation('iau', time, 0.0_dp, parameters, earth, failure)
        call pass_on(failure, status, error)
        if (status == STATUS_OK) rotation = transpose(earth%from_inertial(seconds))
    end function c_earth_orientation
end module gracecg_interface_c_general
