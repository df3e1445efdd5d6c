!> Attitude and orbit of the spans of a manoeuvre from Level-1 files, in GPS time and SRF, and the field, which depends on both.
module gracecg_level1_attitude_reading
    use gracecg_level1_basics
    use gracecg_base_quaternion, only: quaternion_of_matrix, rotation_angle_between
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model
    use gracecg_environment_time, only: decimal_year
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t, leave_out, note, SPAN_MARGIN, &
        find_files, read_product, without_bits, no_attitude, utc_at
    use gracecg_level1_frames, only: gracecg_quaternion, continuous_quaternions, mounting_of_head, attitude_by_head, &
        inertial_of_earth_fixed_by_states, inertial_of_earth_fixed
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_series, only: find_strays
    implicit none
    private
    public :: read_attitude, combine_heads, check_pointing

    integer, parameter :: HEADS = 3
    real(dp), parameter :: ORBIT_MARGIN = 130   !! Orbits are read so much farther, s: two records of every product

    !> Of a head across its boresight and about it; their ratio alone counts (GRACE-FO C and D at 2 Hz: 1 to 4 and 20 to
    !> 42 arcsec)
    real(dp), parameter :: ACROSS = 2.5_dp, ABOUT = 30

contains

    !> Attitude by SCA1B, or SCA1A and QSA1B, and with the orbit what depends on it: position and field.
    subroutine read_attitude(calibration, windows, error)
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)    !! (2, n): begin and end, s
        type(error_t), allocatable, intent(out) :: error

        type(level1_records_t) :: fixed, inertial
        class(geomagnetic_model_t), allocatable :: model
        real(dp), allocatable :: times(:), q(:, :)
        type(string_t), allocatable :: found(:), others(:)
        logical :: has_fixed, has_inertial
        integer :: i

        call star_cameras()
        if (allocated(error)) return
        call find_files(calibration, ['GNV1B'], found)
        call find_files(calibration, ['GNI1B'], others)
        has_fixed = size(found) > 0
        has_inertial = size(others) > 0
        if (.not. (has_fixed .or. has_inertial)) then
            call fail(error, 'no file of product GNV1B or GNI1B of satellite '//calibration%satellite//': the orbit is not known')
            return
        end if
        if (has_fixed) call read_orbit(found, fixed)
        if (has_inertial .and. .not. allocated(error)) call read_orbit(others, inertial)
        if (allocated(error)) return
        associate (file => calibration%setup%field_file)
            call new_geomagnetic_model(pick_text(file == '', 'igrf14', 'file'), decimal_year(utc_at(calibration, 0.0_dp)), &
                                       trim(file), model, error)
        end associate
        if (allocated(error)) return
        if (.not. (has_fixed .and. has_inertial)) call note(calibration, 'no '//merge('GNI1B', 'GNV1B', has_fixed)// &
            ': Earth-fixed to inertial axes by precession, nutation and UT1 = UTC (some arcsec)'// &
            pick_text(has_fixed, '', '; signs of the accelerometer are not compared with air and light'))
        do i = 1, size(calibration%spans)
            if (has_fixed) call check_orbit(fixed, calibration%spans(i))
            if (has_inertial) call check_orbit(inertial, calibration%spans(i))
            call span_attitude(calibration%spans(i))
        end do
        call check_pointing(calibration%spans, error)

    contains

        subroutine read_orbit(found, orbit)
            type(string_t), intent(in) :: found(:)
            type(level1_records_t), intent(out) :: orbit

            character(4), parameter :: STATE(6) = ['xpos', 'ypos', 'zpos', 'xvel', 'yvel', 'zvel']
            real(dp), parameter :: LOWEST = 6.4e6_dp        ! m
            real(dp), parameter :: LONGEST = 70, FAR = 0.05_dp      ! s; of the way, its curvature makes 5e-4
            real(dp) :: wider(2, size(windows, 2)), nearest, off(3)
            integer :: i, k, wrong(3)

            wider(1, :) = windows(1, :) - ORBIT_MARGIN
            wider(2, :) = windows(2, :) + ORBIT_MARGIN
            call read_product(found, calibration, STATE, orbit, error, wider)
            if (allocated(error)) return
            if (orbit%count < 2) then
                call fail(error, orbit%path//': no orbit within the spans of the manoeuvre')
                return
            end if
            nearest = minval([(norm2(orbit%values(i, :3)), i=1, orbit%count)])
            wrong = 0
            do i = 2, orbit%count
                associate (first => orbit%values(i - 1, :), last => orbit%values(i, :), &
                           step => orbit%seconds(i) - orbit%seconds(i - 1) + orbit%fraction(i) - orbit%fraction(i - 1))
                    if (.not. step > 0 .or. step > LONGEST) cycle
                    off = abs(last(:3) - first(:3) - step*(first(4:) + last(4:))/2)
                    where (off > FAR*step*norm2(last(4:))) wrong = wrong + 1
                end associate
            end do
            k = maxloc(wrong, 1)
            if (wrong(k) > orbit%count/10) call fail(error, orbit%path//': positions and velocities along '//AXES(k)// &
                ' do not belong together: sign, unit or order of these columns')
            if (nearest < LOWEST) call fail(error, orbit%path//': a position is '//trim(rounded_text(nearest, 4))//' m from '// &
                'the Earth''s centre, at least '//trim(rounded_text(LOWEST, 3))//' m is allowed: is it in km?')
        end subroutine read_orbit

        !> Leaves a span out that the records of an orbit do not reach around, or with a gap.
        subroutine check_orbit(orbit, span)
            type(level1_records_t), intent(in) :: orbit
            type(level1_span_t), intent(inout) :: span

            real(dp), parameter :: NEEDED = 5       ! s, around the span
            real(dp) :: times(orbit%count), first, last

            times = real(orbit%seconds - calibration%epoch, dp) + orbit%fraction
            first = span%start - NEEDED
            last = span%stop + NEEDED
            if (times(1) <= first .and. times(size(times)) >= last) then
                if (all(times(2:) - times(:size(times) - 1) < ORBIT_MARGIN .or. times(2:) < first .or. &
                        times(:size(times) - 1) > last)) return
            end if
            call leave_out(span, 'a gap in the orbit')
        end subroutine check_orbit

        !> Attitude, rate, position and field of one span.
        subroutine span_attitude(span)
            type(level1_span_t), intent(inout) :: span

            integer, allocatable :: wanted(:)
            real(dp), allocatable :: inertial_field(:, :)
            real(dp) :: c(3, 3), iau(3, 3), r(3), v(3), rf(3), vf(3), b(3)
            integer :: n, i, first, last

            wanted = pack([(i, i=1, size(times))], times >= span%start - SPAN_MARGIN - 2 .and. times <= span%stop + SPAN_MARGIN + 2)
            n = size(wanted)
            span%attitude_time = times(wanted)
            span%quaternion = q(:, wanted)
            allocate (span%angle(3, n), span%rate(3, n), span%field(3, n), span%field_rate(3, n), &
                      span%position(3, n))
            if (n < 10) then
                call leave_out(span, 'no attitude')
                return
            end if
            allocate (inertial_field(3, n))
            span%angle(:, 1) = 0
            do i = 2, n
                span%angle(:, i) = span%angle(:, i - 1) + rotation_between(q(:, wanted(i - 1)), q(:, wanted(i)))
            end do
            do i = 1, n
                first = max(1, i - 1)
                last = min(n, i + 1)
                span%rate(:, i) = (span%angle(:, last) - span%angle(:, first))/ &
                    (span%attitude_time(last) - span%attitude_time(first))
                if (has_fixed) call state_at(fixed, calibration%epoch, span%attitude_time(i), rf, vf)
                if (has_inertial) call state_at(inertial, calibration%epoch, span%attitude_time(i), r, v)
                if (has_fixed .and. has_inertial) then
                    c = inertial_of_earth_fixed_by_states(r, v, rf, vf)
                else
                    c = inertial_of_earth_fixed(utc_at(calibration, span%attitude_time(i)))
                    if (.not. has_fixed) rf = matmul(r, c)
                end if
                call model%evaluate(rf, b)
                span%position(:, i) = matmul(c, rf)
                span%field(:, i) = matmul(matmul(rotation_matrix(q(:, wanted(i))), c), b)
                inertial_field(:, i) = matmul(c, b)
            end do
            do i = 1, n
                first = max(1, i - 1)
                last = min(n, i + 1)
                span%field_rate(:, i) = matmul(rotation_matrix(q(:, wanted(i))), inertial_field(:, last) - &
                                               inertial_field(:, first))/(span%attitude_time(last) - span%attitude_time(first))
            end do
            if (has_fixed .and. has_inertial) then
                iau = inertial_of_earth_fixed(utc_at(calibration, 0.0_dp))
                calibration%poles_apart = max(calibration%poles_apart, norm2(c(:, 3) - iau(:, 3)))
            end if
            span%mean_field = sum(span%field, 2)/n
        end subroutine span_attitude

        !> Leaves out attitudes far off their neighbours of the same head in a span.
        subroutine drop_strays(head)
            integer, allocatable, intent(inout) :: head(:)

            real(dp), parameter :: NOISE = 1e-6_dp      ! rad
            real(dp), allocatable :: turned(:, :)
            logical :: stray(size(times)), inside(size(times))
            integer, allocatable :: wanted(:)
            integer :: i, k, span

            stray = .false.
            do span = 1, size(calibration%spans)
                associate (s => calibration%spans(span))
                    inside = times >= s%start - SPAN_MARGIN - 2 .and. times <= s%stop + SPAN_MARGIN + 2
                end associate
                do i = 1, HEADS
                    wanted = pack([(k, k=1, size(times))], inside .and. head == i)
                    if (size(wanted) == 0) cycle
                    turned = reshape([(rotation_between(q(:, wanted(1)), q(:, wanted(k))), k=1, size(wanted))], [3, size(wanted)])
                    stray(wanted) = stray(wanted) .or. find_strays(times(wanted), turned, NOISE)
                end do
            end do
            if (.not. any(stray)) return
            call note(calibration, 'star cameras: '//integer_text(count(stray))//' of '//integer_text(size(times))// &
                      ' attitudes are far off their neighbours and left out')
            wanted = pack([(k, k=1, size(times))], .not. stray)
            times = times(wanted)
            q = q(:, wanted)
            head = head(wanted)
        end subroutine drop_strays

        !> Times and quaternions, inertial to SRF, scalar last.
        subroutine star_cameras()
            character(10), parameter :: FIELDS(7) = [character(10) :: 'quatangle', 'quaticoeff', 'quatjcoeff', 'quatkcoeff', &
                                                     'sca_id', 'qualflg', 'sca_mode']
            type(level1_records_t) :: sca, qsa
            real(dp), allocatable :: joint_times(:), joint_q(:, :)
            real(dp) :: mounting(4, HEADS)
            type(string_t), allocatable :: found(:), others(:)
            character(:), allocatable :: names
            logical :: heads_alone, known(HEADS)
            logical, allocatable :: wrong(:)
            integer, allocatable :: numbers(:)      ! Of heads
            integer :: i, k, head

            call find_files(calibration, ['SCA1B'], found)
            heads_alone = size(found) == 0
            if (.not. heads_alone) then
                call read_product(found, calibration, FIELDS(:6), sca, error, windows)
                if (allocated(error)) return
                if (sca%count > 0) call sca%drop(.not. without_bits(sca, [0]))
            else
                call find_files(calibration, ['SCA1A'], found)
                call find_files(calibration, ['QSA1B'], others)
                if (size(found) == 0 .or. size(others) == 0) then
                    call fail(error, 'no file of product SCA1B, or SCA1A with QSA1B, of satellite '//calibration%satellite// &
                              ': the attitude is not known')
                    return
                end if
                call read_level1(others, qsa, error)
                if (allocated(error)) return
                call read_product(found, calibration, FIELDS, sca, error, windows)
                if (allocated(error)) return
                if (sca%count > 0) call sca%drop([(.not. btest(nint(sca%values(k, 7)), 0), k=1, sca%count)])
                names = ''
                do head = 1, HEADS
                    mounting(:, head) = mounting_of_head(qsa, head, calibration%epoch)
                    known(head) = norm2(mounting(:, head)) > 0.5_dp
                    if (any(nint(sca%values(:sca%count, 5)) == head) .and. known(head)) names = names//' '//integer_text(head)
                end do
                if (sca%count > 0) call sca%drop([(.not. any(nint(sca%values(k, 5)) == pack([1, 2, 3], known)), k=1, sca%count)])
                if (sca%count > 0) call note(calibration, 'no SCA1B: attitude by the heads of SCA1A together:'//names)
            end if
            wrong = no_attitude(sca)
            if (count(wrong) > 0) then
                call note(calibration, 'star cameras: '//integer_text(count(wrong))//' records hold no unit quaternion and are '// &
                          'left out')
                call sca%drop(wrong)
            end if
            if (sca%count < 30) then
                call fail(error, sca%path//': no attitude within the spans of the manoeuvre')
                return
            end if
            call sca%times_since(calibration%epoch, times)
            allocate (q(4, sca%count))
            do i = 1, sca%count
                q(:, i) = gracecg_quaternion(sca%values(i, 1:4))
                if (heads_alone) q(:, i) = attitude_by_head(mounting(:, nint(sca%values(i, 5))), q(:, i))
            end do
            call continuous_quaternions(q)
            numbers = merge(nint(sca%values(:sca%count, 5)), 1, heads_alone)
            call drop_strays(numbers)
            if (heads_alone) then
                call combine_heads(times, numbers, q, mounting, joint_times, joint_q)
                call move_alloc(joint_times, times)
                call move_alloc(joint_q, q)
            end if
            call continuous_quaternions(q)
        end subroutine star_cameras
    end subroutine read_attitude

    !> Fails where by the attitude the satellite does not fly as these do, z to the Earth and x along the flight or against it; with
    !> the order and direction of quaternions by which it would.
    subroutine check_pointing(spans, error)
        type(level1_span_t), intent(in) :: spans(:)     !! With their attitudes and positions
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: FARTHEST = 30*DEGREE     ! Chosen: they stay within some degrees
        character(40), parameter :: READINGS(3) = [character(40) :: 'have the scalar last', &
            'turn from SRF to inertial axes', 'turn from SRF, with the scalar last']
        real(dp) :: turned(0:3), q(4), last(4)
        integer :: i, k

        turned = 0
        do i = 1, size(spans)
            if (.not. spans(i)%used) cycle
            if (size(spans(i)%attitude_time) < 2) cycle
            k = size(spans(i)%attitude_time)/2
            q = spans(i)%quaternion(:, k)
            last = q([4, 1, 2, 3])
            associate (r => spans(i)%position(:, k), ahead => spans(i)%position(:, k + 1))
                turned = max(turned, [off_the_flight(q, r, ahead), off_the_flight(last, r, ahead), &
                                      off_the_flight([-q(:3), q(4)], r, ahead), off_the_flight([-last(:3), last(4)], r, ahead)])
            end associate
        end do
        if (turned(0) < FARTHEST) return
        k = minloc(turned(1:), 1)
        call fail(error, 'attitude of the star cameras: z and x of the satellite are up to '// &
                  integer_text(nint(turned(0)/DEGREE))//' deg off the Earth and its flight; '// &
                  pick_text(turned(k) < FARTHEST, 'they are not if the quaternions '//trim(READINGS(k))//': the columns are '// &
                            'quatangle, quaticoeff, quatjcoeff, quatkcoeff, from inertial axes to SRF', &
                            'attitude or orbit are of another satellite, another time, or other axes'))
    end subroutine check_pointing

    !> By which angle SRF are turned from z to the Earth and x along the flight, or against it, rad.
    pure real(dp) function off_the_flight(q, position, ahead) result(angle)
        real(dp), intent(in) :: q(4)                !! Inertial to SRF, scalar last
        real(dp), intent(in) :: position(3), ahead(3)       !! Inertial, now and a little later, m

        real(dp), parameter :: BACKWARDS(4) = [0.0_dp, 0.0_dp, 1.0_dp, 0.0_dp]
        real(dp) :: x(3), y(3), z(3), along(4)

        z = -position/norm2(position)
        y = cross(z, ahead)
        y = y/norm2(y)
        x = cross(y, z)
        along = quaternion_of_matrix(transpose(reshape([x, y, z], [3, 3])))
        angle = min(rotation_angle_between(along, q), rotation_angle_between(quaternion_product(BACKWARDS, along), q))
    end function off_the_flight

    !> Position and velocity between two records, by Hermite's cubic.
    pure subroutine state_at(orbit, epoch, time, r, v)
        type(level1_records_t), intent(in) :: orbit
        integer(i8), intent(in) :: epoch
        real(dp), intent(in) :: time                !! s from the epoch
        real(dp), intent(out) :: r(3), v(3)

        real(dp) :: h, u
        integer :: k

        k = int(max(1, min(orbit%count - 1, count(real(orbit%seconds - epoch, dp) + orbit%fraction <= time))))
        h = real(orbit%seconds(k + 1) - orbit%seconds(k), dp) + orbit%fraction(k + 1) - orbit%fraction(k)
        u = (time - real(orbit%seconds(k) - epoch, dp) - orbit%fraction(k))/h
        associate (r1 => orbit%values(k, 1:3), r2 => orbit%values(k + 1, 1:3), v1 => orbit%values(k, 4:6), &
                   v2 => orbit%values(k + 1, 4:6))
            r = (1 + 2*u)*(1 - u)**2*r1 + u**2*(3 - 2*u)*r2 + h*(u*(1 - u)**2*v1 - u**2*(1 - u)*v2)
            v = 6*u*(u - 1)/h*(r1 - r2) + (1 - u)*(1 - 3*u)*v1 + u*(3*u - 2)*v2
        end associate
    end subroutine state_at

    !> One attitude for each time at which some head has one. What a head is turned from the one with most records in
    !> the mean of their common times is taken away; then
    !>
    !>     q = dq(e) q_1,  e = (sum_h W_h)^-1 sum_h W_h e_h,  W_h = R_h diag(1/s_x^2, 1/s_x^2, 1/s_z^2) R_h^T
    !>
    !> with e_h the rotation vector of head h from the first head of that time, and R_h its mounting.
    subroutine combine_heads(times, head, q, mounting, joint_times, joint_q)
        real(dp), intent(in) :: times(:)            !! Not falling, s
        integer, intent(in) :: head(:)              !! Its number, of each record
        real(dp), intent(in) :: q(:, :)             !! (4, n): inertial to SRF by that head, scalar last
        real(dp), intent(in) :: mounting(:, :)      !! (4, heads): head to SRF, scalar last
        real(dp), allocatable, intent(out) :: joint_times(:)    !! Rising, s
        real(dp), allocatable, intent(out) :: joint_q(:, :)     !! (4, times)

        real(dp), parameter :: EQUAL = 1e-3_dp      ! s
        real(dp) :: turned(3, size(mounting, 2)), weight(3, 3, size(mounting, 2)), sum_of_weights(3, 3), weighted(3), r(3, 3), &
            phi(3)
        integer :: common(size(mounting, 2)), reference, i, k, n, first, last

        reference = 1
        do i = 2, size(mounting, 2)
            if (count(head == i) > count(head == reference)) reference = i
        end do
        do i = 1, size(mounting, 2)
            r = rotation_matrix(mounting(:, i))
            weight(:, :, i) = matmul(r, reshape([1/ACROSS**2, 0.0_dp, 0.0_dp, 0.0_dp, 1/ACROSS**2, 0.0_dp, 0.0_dp, 0.0_dp, &
                                                 1/ABOUT**2], [3, 3]))
            weight(:, :, i) = matmul(weight(:, :, i), transpose(r))
        end do
        turned = 0
        common = 0
        allocate (joint_times(size(times)), joint_q(4, size(times)))
        first = 1
        do while (first <= size(times))         ! means of the common times
            last = last_of_equal(first)
            do i = first, last
                if (head(i) /= reference) cycle
                do k = first, last
                    turned(:, head(k)) = turned(:, head(k)) + rotation_between(q(:, i), q(:, k))
                    common(head(k)) = common(head(k)) + 1
                end do
            end do
            first = last + 1
        end do
        turned = turned/spread(max(1, common), 1, 3)
        n = 0
        first = 1
        do while (first <= size(times))
            last = last_of_equal(first)
            sum_of_weights = 0
            weighted = 0
            do k = first, last
                sum_of_weights = sum_of_weights + weight(:, :, head(k))
                weighted = weighted + matmul(weight(:, :, head(k)), rotation_between(q(:, first), q(:, k)) - turned(:, head(k)))
            end do
            n = n + 1
            joint_times(n) = times(first)
            phi = matmul(inverse_3x3(sum_of_weights), weighted)
            joint_q(:, n) = quaternion_product(normalised([phi/2, 1 - dot_product(phi, phi)/8]), q(:, first))  ! to its third power
            first = last + 1
        end do
        joint_times = joint_times(:n)
        joint_q = joint_q(:, :n)

    contains

        pure integer function last_of_equal(first) result(last)
            integer, intent(in) :: first

            last = first
            do while (last < size(times))
                if (times(last + 1) - times(first) > EQUAL) exit
                last = last + 1
            end do
        end function last_of_equal
    end subroutine combine_heads
end module gracecg_level1_attitude_reading
