!> The C interface, misused as C can misuse it: refused with a status and a message.
module test_c_misuse
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_null_char, c_size_t
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_positive_inf
    use vocabulary
    use gracecg_files_file, only: make_directory
    use gracecg_interface_handles, only: live_objects, MAX_OBJECTS
    use c_library
    use c_checks
    implicit none
    private
    public :: collect_c_misuse

contains

    subroutine collect_c_misuse(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('null-pointers', test_null), &
                    new_unittest('invalid-handles', test_handles), &
                    new_unittest('freed-twice', test_freed_twice), &
                    new_unittest('too-many-objects', test_too_many), &
                    new_unittest('wrong-names', test_names), &
                    new_unittest('values-not-finite', test_not_finite), &
                    new_unittest('wrong-sizes', test_sizes), &
                    new_unittest('states-out-of-range', test_states), &
                    new_unittest('long-texts', test_long_texts), &
                    new_unittest('level1-estimate-misused', test_level1_misuse), &
                    new_unittest('nothing-is-left', test_nothing_left)]
    end subroutine collect_c_misuse

    !> Every pointer that is needed, left out.
    subroutine test_null(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_struct) :: utc
        integer(c_intptr_t) :: handle, case, model, gravity
        real(dp) :: x(13)

        call check_refused(error, NULL_POINTER, 'text', gracecg_utc_parse(utc=utc, error=failure))
        call check_refused(error, NULL_POINTER, 'utc', gracecg_utc_parse(c_string(DATE), error=failure))
        status = gracecg_gravity_open(degree=2, order=0, gravity=gravity, error=failure)
        call check_refused(error, NULL_POINTER, 'name_or_file')
        call check_refused(error, NULL_POINTER, 'gravity', gracecg_gravity_open(c_string('egm96'), 2, 2, error=failure))
        status = gracecg_gravity_open(c_string('egm96'), 2, 2, gravity, failure)
        status = gracecg_gravity_evaluate(gravity, ONE, acceleration=x, error=failure)
        call check_refused(error, NULL_POINTER, 'position')
        status = gracecg_free(gravity)
        call check_refused(error, NULL_POINTER, 'object', gracecg_free(error=failure))
        call check_refused(error, NULL_POINTER, 'date', gracecg_field_open(c_string('igrf95'), field=handle, error=failure))
        status = gracecg_sun_position(n=ONE, seconds=[0.0_dp], position=x, error=failure)
        call check_refused(error, NULL_POINTER, 'epoch')
        call check_refused(error, NULL_POINTER, 'name_file_or_text', gracecg_case_open(the_case=case, error=failure))
        status = gracecg_case_open(c_string('front-1'), case, failure)
        call check_refused(error, NULL_POINTER, 'text', gracecg_get_text(case, c_string('text'), size=NONE, error=failure))
        call check_refused(error, NULL_POINTER, 'text', gracecg_get_text(case, c_string('text'), size=ONE, error=failure))
        call check_refused(error, NULL_POINTER, 'model', gracecg_force_model_open(case, error=failure))
        status = gracecg_force_model_open(case, model, failure)
        x = 7e6_dp
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], x, x, error=failure)
        call check_refused(error, NULL_POINTER, 'quaternion')
        call check_refused(error, NULL_POINTER, 'state', gracecg_force_model_loads(model, 0.0_dp, rate=x, error=failure))
        x(10:13) = 0.5_dp
        status = gracecg_force_model_propagate(model, x, 0, 1.0_dp, ONE, 0.0_dp, error=failure)
        call check_refused(error, NULL_POINTER, 'states')
        call free(model, case)
        status = gracecg_estimate(observations=0_c_intptr_t, fit=handle, error=failure)
        call check_refused(error, NULL_POINTER, 'algorithm')
        call check_refused(error, NULL_POINTER, 'fit', gracecg_estimate(c_string('ascfest'), 0_c_intptr_t, error=failure))
        call check_refused(error, NULL_POINTER, 'item', gracecg_get(0_c_intptr_t, capacity=NONE, error=failure))
        ! and nobody asks for the message
        status = gracecg_case_open()
        call check(error, int(status), int(NULL_POINTER))
    end subroutine test_null

    !> Numbers that are no handle, and handles of another kind.
    subroutine test_handles(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_struct) :: epoch
        integer(c_intptr_t) :: case, wrong(6), out
        integer(c_size_t) :: n(1)
        integer :: i
        real(dp) :: x(39)

        status = gracecg_case_open(c_string('front-1'), case, failure)
        wrong = [0_c_intptr_t, -1_c_intptr_t, huge(0_c_intptr_t), -huge(0_c_intptr_t), &
                 int(z'7fff12345678', c_intptr_t), case]
        x = 1e7_dp
        x(10:13) = 0.5_dp
        epoch = utc_struct(47528, 0.0_dp)
        do i = 1, size(wrong)
            status = gracecg_gravity_evaluate(wrong(i), ONE, x, x, error=failure)
            call check_refused(error, BAD_HANDLE, 'gravity model')
            status = gracecg_field_evaluate(wrong(i), ONE, x, x, error=failure)
            call check_refused(error, BAD_HANDLE, 'geomagnetic field')
            status = gracecg_density_evaluate(wrong(i), epoch, ONE, [0.0_dp], x, x, error=failure)
            call check_refused(error, BAD_HANDLE, 'density')
            status = gracecg_wind_evaluate(wrong(i), epoch, ONE, [0.0_dp], x, x, error=failure)
            call check_refused(error, BAD_HANDLE, 'wind')
            status = gracecg_earth_radiation_evaluate(wrong(i), epoch, ONE, [0.0_dp], x, x, error=failure)
            call check_refused(error, BAD_HANDLE, 'Earth radiation')
            status = gracecg_force_model_evaluate(wrong(i), ONE, [0.0_dp], x, x, x(10:13), error=failure)
            call check_refused(error, BAD_HANDLE, 'force model')
            status = gracecg_force_model_loads(wrong(i), 0.0_dp, x, rate=x, error=failure)
            call check_refused(error, BAD_HANDLE, 'force model')
            status = gracecg_force_model_propagate(wrong(i), x, 0, 1.0_dp, ONE, 0.0_dp, x, failure)
            call check_refused(error, BAD_HANDLE, 'force model')
            call check_refused(error, BAD_HANDLE, 'simulator', gracecg_simulate(wrong(i), 1, 1, out, failure))
            status = gracecg_observations_create(wrong(i), NONE, star_camera_count=NONE, magnetometer_count=NONE, &
                                                 orbit_count=NONE, observations=out, error=failure)
            call check_refused(error, BAD_HANDLE, 'setup')
            status = gracecg_observations_write(wrong(i), c_string(FOLDER//'never'), failure)
            call check_refused(error, BAD_HANDLE, 'observation set')
            status = gracecg_estimate(c_string('ascfest'), wrong(i), out, failure)
            call check_refused(error, BAD_HANDLE, 'observation set')
            if (wrong(i) == case) cycle
            status = gracecg_get_text(wrong(i), c_string('text'), size=NONE, length=n(1), error=failure)
            call check_refused(error, BAD_HANDLE, 'gracecg object')
            status = gracecg_get(wrong(i), c_string('state'), NONE, count=n(1), error=failure)
            call check_refused(error, BAD_HANDLE, 'gracecg object')
            out = wrong(i)
            if (out /= 0) status = gracecg_free(out, failure)
            if (out /= 0) call check_refused(error, BAD_HANDLE, 'gracecg object')
            call check_refused(error, BAD_HANDLE, 'case', gracecg_force_model_open(wrong(i), out, failure))
            call check_refused(error, BAD_HANDLE, 'case', gracecg_simulator_open(wrong(i), out, failure))
        end do
        status = gracecg_free(case)
    end subroutine test_handles

    !> A handle that was freed is never valid again, also when its place is taken by another object.
    subroutine test_freed_twice(error)
        type(error_type), allocatable, intent(out) :: error
        integer(c_intptr_t) :: gravity, copy, other
        real(dp) :: a(3)
        integer :: i

        status = gracecg_gravity_open(c_string('egm96'), 2, 2, gravity, failure)
        copy = gravity
        status = gracecg_free(gravity, failure)
        status = gracecg_free(gravity, failure)
        call check(error, int(status), int(OK), 'NULL may be freed')
        do i = 1, 3*MAX_OBJECTS     ! every place is taken three times
            status = gracecg_gravity_open(c_string('point-mass'), 0, 0, other, failure)
            if (other == copy) exit
            status = gracecg_free(other)
        end do
        call check(error, i > 3*MAX_OBJECTS, 'a handle was given out twice')
        call check_refused(error, BAD_HANDLE, 'was freed', gracecg_gravity_evaluate(copy, ONE, PLACE, a, error=failure))
        call check_refused(error, BAD_HANDLE, 'was freed', gracecg_free(copy, failure))
        call check(error, copy /= 0, 'a refused free changes the handle')
    end subroutine test_freed_twice

    subroutine test_too_many(error)
        type(error_type), allocatable, intent(out) :: error
        integer(c_intptr_t) :: handles(MAX_OBJECTS + 1)
        integer :: i, n

        n = MAX_OBJECTS - live_objects()
        handles = 0
        do i = 1, n
            status = gracecg_gravity_open(c_string('point-mass'), 0, 0, handles(i), failure)
            if (status /= OK) exit
        end do
        call check_ok(error)
        status = gracecg_gravity_open(c_string('point-mass'), 0, 0, handles(n + 1), failure)
        call check_refused(error, NO_MEMORY, 'objects already')
        call check(error, handles(n + 1) == 0, 'a handle after a failure')
        do i = 1, n
            status = gracecg_free(handles(i), failure)
        end do
        call check(error, live_objects(), MAX_OBJECTS - n, 'objects are left')
    end subroutine test_too_many

    subroutine test_names(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_struct) :: utc
        integer(c_intptr_t) :: handle, fit

        status = gracecg_case_open(c_string('frnt-1'), handle, failure)
        call check_refused(error, HAS_FAILED, 'did you mean "front-1"')
        status = gracecg_gravity_open(c_string('egm69'), 2, 2, handle, failure)
        call check_refused(error, HAS_FAILED, 'did you mean "egm96"')
        status = gracecg_gravity_open(c_string(''), 2, 2, handle, failure)
        call check_refused(error, HAS_FAILED, 'no gravity model ""')
        call check_refused(error, HAS_FAILED, 'nor a file', gracecg_gravity_open(c_string('test'), 2, 2, handle, failure))
        call check_refused(error, HAS_FAILED, 'fpm.toml', gracecg_gravity_open(c_string('fpm.toml'), 2, 2, handle, failure))
        status = gracecg_utc_parse(c_string(DATE), utc)
        status = gracecg_field_open(c_string('igrf59'), utc, handle, failure)
        call check_refused(error, HAS_FAILED, 'did you mean "igrf95"')
        call check_refused(error, HAS_FAILED, 'did you mean "hwm93"', gracecg_wind_open(c_string('hwm39'), handle, failure))
        call check(error, handle == 0, 'a handle after a failure')
        call simulate('front-1', 1, 1, handle)
        status = gracecg_estimate(c_string('assest'), handle, fit, failure)
        call check_refused(error, HAS_FAILED, 'no algorithm "assest"')
        status = gracecg_free(handle)
    end subroutine test_names

    !> NaN and infinity at every place where a number comes in.
    subroutine test_not_finite(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_struct) :: epoch
        integer(c_intptr_t) :: case, model, gravity, light, handle
        real(dp) :: bad(2), state(13), x(13), a(13)
        integer :: i, k

        bad = [NAN, ieee_value(1.0_dp, ieee_positive_inf)]
        status = gracecg_utc_parse(c_string(DATE), epoch)
        status = gracecg_case_open(c_string('front-1'), case)
        state = item(case, 'state', 13)
        status = gracecg_force_model_open(case, model)
        status = gracecg_gravity_open(c_string('egm96'), 2, 2, gravity)
        do k = 1, 2
            do i = 1, 13
                x = state
                x(i) = bad(k)
                status = gracecg_force_model_loads(model, 0.0_dp, x, rate=a, error=failure)
                call check_refused(error, BAD_VALUE, 'of state is NaN or infinite')
                status = gracecg_force_model_propagate(model, x, 0, 0.1_dp, NONE, 0.0_dp, a, failure)
                call check_refused(error, BAD_VALUE, 'is NaN or infinite')
                if (i >= 7 .and. i <= 9) cycle      ! the angular velocity
                status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], x(1:3), x(4:6), x(10:13), &
                                                      error=failure)
                call check_refused(error, BAD_VALUE, 'is NaN or infinite')
            end do
            status = gracecg_force_model_evaluate(model, ONE, bad(k:k), state(1:3), state(4:6), state(10:13), &
                                                  error=failure)
            call check_refused(error, BAD_VALUE, 'seconds')
            status = gracecg_force_model_propagate(model, state, 0, bad(k), NONE, 0.0_dp, a, failure)
            call check_refused(error, BAD_VALUE, 'interval')
            status = gracecg_force_model_propagate(model, state, 0, 0.1_dp, NONE, bad(k), a, failure)
            call check_refused(error, BAD_VALUE, 'tolerance')
            status = gracecg_gravity_evaluate(gravity, ONE, [PLACE(:2), bad(k)], a, error=failure)
            call check_refused(error, BAD_VALUE, 'number 3 of position')
            call check_refused(error, BAD_VALUE, 'seconds', gracecg_sun_position(epoch, ONE, bad(k:k), a, failure))
            status = gracecg_sun_position(utc_struct(47528, bad(k)), ONE, [0.0_dp], a, failure)
            call check_refused(error, BAD_VALUE, 'seconds are those of the day')
            status = gracecg_sun_illumination(ONE, PLACE, [bad(k), 0.0_dp, 0.0_dp], a, failure)
            call check_refused(error, BAD_VALUE, 'sun')
            status = gracecg_density_open(c_string('dtm77'), indices=[bad(k), 150.0_dp, 2.0_dp], density=handle, error=failure)
            call check_refused(error, BAD_VALUE, 'indices')
            status = gracecg_earth_radiation_open(c_string('report'), 1, bad(k), handle, failure)
            call check_refused(error, BAD_VALUE, 'irradiance')
        end do
        status = gracecg_sun_position(epoch, ONE, [1e12_dp], a, failure)
        call check_refused(error, BAD_VALUE, '000E+12 s from the epoch: at most 9e9 s')
        ! what would overflow on the way
        status = gracecg_earth_radiation_open(c_string('report'), 1, 1367.0_dp, light)
        status = gracecg_earth_radiation_evaluate(light, epoch, ONE, [0.0_dp], 1e200_dp*PLACE, a, error=failure)
        call check_refused(error, BAD_VALUE, 'in metres, 6.35e6 to 1e9')
        call free(light, gravity, model, case)
    end subroutine test_not_finite

    subroutine test_sizes(error)
        type(error_type), allocatable, intent(out) :: error
        integer(c_intptr_t) :: gravity, observations
        real(dp) :: x(3), t(1)

        x = PLACE
        status = gracecg_gravity_open(c_string('point-mass'), 0, 0, gravity)
        status = gracecg_gravity_evaluate(gravity, -1_c_size_t, x, x, error=failure)    ! SIZE_MAX
        call check_refused(error, BAD_SIZE, 'n is negative or too great')
        status = gracecg_gravity_evaluate(gravity, 3000000000_c_size_t, x, x, error=failure)
        call check_refused(error, BAD_SIZE, 'n = 3000000000 is outside')
        status = gracecg_free(gravity)
        call simulate('front-1', 1, 1, observations)
        status = gracecg_get(observations, c_string('accelerometer_time'), 599_c_size_t, t, error=failure)
        call check_refused(error, BAD_SIZE, 'there are 600')
        status = gracecg_get(observations, c_string('star_camera_time'), NONE, t, error=failure)
        call check_refused(error, BAD_SIZE, 'there are 240')
        status = gracecg_get(observations, c_string('orbit_time'), -5_c_size_t, t, error=failure)
        call check_refused(error, BAD_SIZE, 'capacity')
        status = gracecg_free(observations)
    end subroutine test_sizes

    subroutine test_states(error)
        type(error_type), allocatable, intent(out) :: error
        integer(c_intptr_t) :: case, model, gravity
        real(dp) :: state(13), a(3)

        status = gracecg_case_open(c_string('front-1'), case)
        state = item(case, 'state', 13)
        status = gracecg_force_model_open(case, model)
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], 0.94_dp*state(1:3), state(4:6), state(10:13), &
                                              total=a, error=failure)
        call check_refused(error, BAD_VALUE, 'km high')
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], 0.5_dp*state(1:3), state(4:6), state(10:13), &
                                              total=a, error=failure)
        call check_refused(error, BAD_VALUE, 'below the ground')
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], 1e-3_dp*state(1:3), state(4:6), state(10:13), &
                                              total=a, error=failure)
        call check_refused(error, BAD_VALUE, 'have to be in metres')       ! they are in kilometres
        status = gracecg_force_model_loads(model, 0.0_dp, [1e-3_dp*state(1:6), state(7:)], error=failure)
        call check_refused(error, BAD_VALUE, 'have to be in metres')
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], state(1:3), 1e3_dp*state(4:6), state(10:13), &
                                              total=a, error=failure)
        call check_refused(error, BAD_VALUE, '0 to 20000 m/s')
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], state(1:3), state(4:6), 0*state(10:13), &
                                              total=a, error=failure)
        call check_refused(error, BAD_VALUE, 'quaternion')
        call free(model, case)
        status = gracecg_gravity_open(c_string('egm96'), 70, 70, gravity)
        status = gracecg_gravity_evaluate(gravity, ONE, [0.0_dp, 0.0_dp, 0.0_dp], a, error=failure)
        call check_refused(error, BAD_VALUE, '0 m from the centre')
        status = gracecg_gravity_evaluate(gravity, ONE, [6.3e6_dp, 0.0_dp, 0.0_dp], a, error=failure)
        call check_refused(error, BAD_VALUE, '6.35e6 to 1e9')
        status = gracecg_free(gravity)
    end subroutine test_states

    !> A text without its end within the limit, and a message that is longer than its place.
    subroutine test_long_texts(error)
        type(error_type), allocatable, intent(out) :: error
        integer(c_intptr_t) :: handle
        character(:), allocatable :: message

        status = gracecg_wind_open(c_string(repeat('a', 4096)), handle, failure)
        call check_refused(error, BAD_VALUE, 'longer than 4095 bytes')
        status = gracecg_case_open(c_string(repeat('a', 2**20 + 1)), handle, failure)
        call check_refused(error, BAD_VALUE, 'longer than 1048576 bytes')
        status = gracecg_wind_open(c_string(repeat('a', 4095)), handle, failure)
        call check_refused(error, HAS_FAILED, 'no wind "aaa')
        message = trim(message_text(failure))
        call check(error, len(message) == 1019 .and. message(1017:) == '...', 'a message that is cut off')
    end subroutine test_long_texts

    !> Every argument NULL, or wrong: refused by name.
    subroutine test_level1_misuse(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: problem
        real(dp) :: spans(2, 1), bad(2, 1)

        call make_directory(FOLDER//'c_level1', problem)
        call make_file('c_level1_setup.nml', '&mass_properties'//new_line('a')//'mass = 580'//new_line('a')// &
                       'moments_of_inertia = 70, 345, 388'//new_line('a')//'products_of_inertia = -3, -0.3, -2.9'// &
                       new_line('a')//'/'//new_line('a')//'&level1'//new_line('a')//'/'//new_line('a'))
        spans(:, 1) = [633798600.0_dp, 60.0_dp]
        bad(:, 1) = [633798600.0_dp, NAN]
        call refuse(NULL_POINTER, 'folder', setup='s'//c_null_char)
        call refuse(NULL_POINTER, 'setup', folder='f'//c_null_char)
        call refuse(NULL_POINTER, 'spans', 'f'//c_null_char, 's'//c_null_char, n_spans=ONE)
        call refuse(BAD_SIZE, 'n_spans', 'f'//c_null_char, 's'//c_null_char, n_spans=-ONE)
        call refuse(BAD_VALUE, 'spans', 'f'//c_null_char, 's'//c_null_char, n_spans=ONE, spans=bad)
        call refuse(BAD_VALUE, 'satellite', 'f'//c_null_char, 's'//c_null_char, satellite='CD'//c_null_char)
        call refuse(HAS_FAILED, 's:', 'f'//c_null_char, 's'//c_null_char)
        call refuse(HAS_FAILED, 'no Level-1 files', FOLDER//'c_level1'//c_null_char, &
                    FOLDER//'c_level1_setup.nml'//c_null_char, n_spans=ONE, spans=spans)
        call refuse(HAS_FAILED, 'no date', FOLDER//'c_level1'//c_null_char, &
                    FOLDER//'c_level1_setup.nml'//c_null_char, day='2020-02-30'//c_null_char)
        call refuse(BAD_VALUE, 'day', FOLDER//'c_level1'//c_null_char, &
                    FOLDER//'c_level1_setup.nml'//c_null_char, day=repeat('2', 5000)//c_null_char)
        call check(error, int(gracecg_level1_estimate(n_spans=NONE)), int(NULL_POINTER), 'without an error to fill')

    contains

        subroutine refuse(expected, part, folder, setup, satellite, day, n_spans, spans)
            integer(c_int), intent(in) :: expected
            character(*), intent(in) :: part
            character(*), intent(in), optional :: folder, setup, satellite, day
            integer(c_size_t), intent(in), optional :: n_spans
            real(dp), intent(in), optional :: spans(:, :)
            integer(c_intptr_t) :: offset
            integer(c_size_t) :: n

            n = NONE
            if (present(n_spans)) n = n_spans
            offset = 77
            status = gracecg_level1_estimate(folder, setup, satellite, day, n, spans, offset, failure)
            call check_refused(error, expected, part)
            call check(error, offset == 0, 'a handle after a failure')
        end subroutine refuse
    end subroutine test_level1_misuse

    !> The tests above have freed all that they made.
    subroutine test_nothing_left(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, live_objects(), 0, 'objects are left')
    end subroutine test_nothing_left
end module test_c_misuse
