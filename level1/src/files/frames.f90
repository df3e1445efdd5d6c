!> The frames of Level-1 data: AF of the accelerometer, those of the star cameras' heads, SRF (the body axes), Earth-fixed and
!> inertial axes; and orbit and attitude between the records of GNV1B, GNI1B and SCA1B.
module gracecg_level1_frames
    use gracecg_level1_basics
    use gracecg_base_constants, only: EARTH_ROTATION_RATE
    use gracecg_environment_earth_orientation, only: earth_orientation_t, earth_parameters_t, iau_orientation
    use gracecg_level1_records, only: level1_records_t
    implicit none
    private
    public :: srf_of_accelerometer, signed_axes_valid, gracecg_quaternion, continuous_quaternions, mounting_of_head, &
        attitude_by_head, calibration_vector, inertial_of_earth_fixed_by_states, inertial_of_earth_fixed, &
        inertial_velocity, ACCELEROMETER_AXES, ORDERS, orbit_at, attitude_at

    !> Which axis of AF, with its sign, x, y and z of SRF are: z, x, y (ACC1A of GRACE-FO against ACT1B)
    integer, parameter :: ACCELEROMETER_AXES(3) = [3, 1, 2]

    !> All orders of three axes, the right one first
    integer, parameter :: ORDERS(3, 6) = reshape([1, 2, 3, 2, 1, 3, 1, 3, 2, 3, 2, 1, 2, 3, 1, 3, 1, 2], [3, 6])

    integer, parameter :: LONGEST_STEP = 60     !! Between records, s: nothing is known in a longer one

contains

    !> Whether three signed axis numbers are each axis once.
    pure logical function signed_axes_valid(axes)
        integer, intent(in) :: axes(3)      !! -3 to 3, without 0

        integer :: i

        signed_axes_valid = all([(count(abs(axes) == i) == 1, i=1, 3)])
    end function signed_axes_valid

    !> A vector of AF (linear or angular) in SRF.
    pure function srf_of_accelerometer(vector, axes) result(srf)
        real(dp), intent(in) :: vector(3)   !! Along x, y, z of AF
        integer, intent(in) :: axes(3)      !! Signed axis of AF for each of SRF; ACCELEROMETER_AXES
        real(dp) :: srf(3)

        srf = sign(1, axes)*vector(abs(axes))
    end function srf_of_accelerometer

    !> A quaternion as gracecg has it, scalar last: the passive rotation of both is the same.
    pure function gracecg_quaternion(scalar_first) result(q)
        real(dp), intent(in) :: scalar_first(4)     !! quatangle, quaticoeff, quatjcoeff, quatkcoeff
        real(dp) :: q(4)

        q = normalised([scalar_first(2:4), scalar_first(1)])
    end function gracecg_quaternion

    !> Turns signs so that each quaternion is the nearer of its two to the one before.
    pure subroutine continuous_quaternions(q)
        real(dp), intent(inout) :: q(:, :)          !! (4, n), in order of time

        integer :: i

        do i = 2, size(q, 2)
            if (dot_product(q(:, i), q(:, i - 1)) < 0) q(:, i) = -q(:, i)
        end do
    end subroutine continuous_quaternions

    !> The number of the record of a calibration history that holds at a time: the last one at or before it; the
    !> first one when all are later. 0: there is none.
    pure integer function record_at(history, seconds, head) result(number)
        type(level1_records_t), intent(in) :: history   !! All fields, in order of time
        integer(i8), intent(in) :: seconds              !! GPS, past 2000-01-01 12:00
        integer, intent(in), optional :: head           !! Of that head (sca_id) only

        integer :: i, column

        column = 0
        if (present(head)) column = history%field_of('sca_id')
        number = 0
        do i = 1, history%count
            if (column > 0) then
                if (nint(history%values(i, column)) /= head) cycle
            end if
            if (number > 0 .and. history%seconds(i) > seconds) exit
            number = i
        end do
    end function record_at

    !> The rotation from a head's frame to SRF at a time, of QSA1B. All zero: the history has no such head.
    pure function mounting_of_head(qsa1b, head, seconds) result(q)
        type(level1_records_t), intent(in) :: qsa1b     !! All fields
        integer, intent(in) :: head                     !! sca_id
        integer(i8), intent(in) :: seconds              !! GPS, past 2000-01-01 12:00
        real(dp) :: q(4)                                !! Scalar last

        integer :: number, first

        q = 0
        number = record_at(qsa1b, seconds, head)
        if (number == 0) return
        first = qsa1b%field_of('quatangle')
        q = gracecg_quaternion(qsa1b%values(number, first:first + 3))
    end function mounting_of_head

    !> The attitude of the satellite, inertial to SRF, by one head: R_SRF = R(q_QSA) R(q_SCA1A).
    pure function attitude_by_head(mounting, head_attitude) result(q)
        real(dp), intent(in) :: mounting(4)         !! Head to SRF, scalar last
        real(dp), intent(in) :: head_attitude(4)    !! Inertial to head, scalar last
        real(dp) :: q(4)                            !! Scalar last

        q = quaternion_product(mounting, head_attitude)
    end function attitude_by_head

    !> The vector of a calibration history (VCM1B, VKB1B, ...) that holds at a time, m in SRF. Zero: there is none.
    pure function calibration_vector(history, seconds) result(vector)
        type(level1_records_t), intent(in) :: history   !! All fields
        integer(i8), intent(in) :: seconds              !! GPS, past 2000-01-01 12:00
        real(dp) :: vector(3)

        integer :: number, first

        vector = 0
        number = record_at(history, seconds)
        if (number == 0) return
        first = history%field_of('mag')
        vector = history%values(number, first)*history%values(number, first + 1:first + 3)
    end function calibration_vector

    !> The rotation from Earth-fixed to inertial axes, of one state in both (GNV1B, GNI1B): C = T(r, v) T(r', V)^T
    !> with the triad T(r, v) = [r/|r|, h x r/|r|, h], h = (r x v)/|r x v|, and V = v' + Omega x r'.
    pure function inertial_of_earth_fixed_by_states(position, velocity, fixed_position, fixed_velocity) result(c)
        real(dp), intent(in) :: position(3), velocity(3)                !! Inertial, m and m/s
        real(dp), intent(in) :: fixed_position(3), fixed_velocity(3)    !! Earth-fixed, m and m/s
        real(dp) :: c(3, 3)

        c = matmul(triad(position, velocity), &
                   transpose(triad(fixed_position, fixed_velocity + cross([0.0_dp, 0.0_dp, EARTH_ROTATION_RATE], fixed_position))))
    end function inertial_of_earth_fixed_by_states

    pure function triad(r, v) result(t)
        real(dp), intent(in) :: r(3), v(3)
        real(dp) :: t(3, 3)

        t(:, 1) = r/norm2(r)
        t(:, 3) = cross(r, v)
        t(:, 3) = t(:, 3)/norm2(t(:, 3))
        t(:, 2) = cross(t(:, 3), t(:, 1))
    end function triad

    !> The rotation from Earth-fixed to inertial axes by precession and nutation of the IAU (the orientation `iau`) with
    !> UT1 = UTC and without polar motion, some arcsec (13 arcsec at 0.9 s of UT1). For GRACE, which has no GNI1B.
    pure function inertial_of_earth_fixed(utc) result(c)
        type(utc_t), intent(in) :: utc
        real(dp) :: c(3, 3)

        type(earth_orientation_t) :: orientation

        orientation = iau_orientation(utc, earth_parameters_t())
        c = transpose(orientation%from_inertial(0.0_dp))
    end function inertial_of_earth_fixed

    !> The inertial velocity of an Earth-fixed state, m/s along inertial axes.
    pure function inertial_velocity(c, fixed_position, fixed_velocity) result(velocity)
        real(dp), intent(in) :: c(3, 3)                                 !! Earth-fixed to inertial
        real(dp), intent(in) :: fixed_position(3), fixed_velocity(3)    !! m and m/s
        real(dp) :: velocity(3)

        velocity = matmul(c, fixed_velocity + cross([0.0_dp, 0.0_dp, EARTH_ROTATION_RATE], fixed_position))
    end function inertial_velocity

    !> State and turning of the Earth at a time, by the orbits that have records. Without GNI1B inertial axes are those of
    !> `inertial_of_earth_fixed`.
    subroutine orbit_at(gnv1b, gni1b, seconds, fraction, inertial, fixed, c, ok)
        type(level1_records_t), intent(in) :: gnv1b, gni1b      !! All fields; either may be without records
        integer(i8), intent(in) :: seconds                      !! GPS, past 2000-01-01 12:00
        real(dp), intent(in) :: fraction                        !! s
        real(dp), intent(out) :: inertial(6), fixed(6)
        !! Position and velocity along inertial and Earth-fixed axes, m and m/s; `fixed` is 0 without GNV1B
        real(dp), intent(out) :: c(3, 3)                        !! Earth-fixed to inertial; 0 without GNV1B
        logical, intent(out) :: ok                              !! They are known

        c = 0
        fixed = 0
        inertial = 0
        ok = gnv1b%count + gni1b%count > 0
        if (ok .and. gnv1b%count > 0) call state_at(gnv1b, seconds, fraction, fixed, ok)
        if (ok .and. gni1b%count > 0) call state_at(gni1b, seconds, fraction, inertial, ok)
        if (.not. ok .or. gnv1b%count == 0) return
        if (gni1b%count > 0) then
            c = inertial_of_earth_fixed_by_states(inertial(:3), inertial(4:), fixed(:3), fixed(4:))
        else
            c = inertial_of_earth_fixed(utc_of_gps(seconds, fraction))
            inertial = [matmul(c, fixed(:3)), inertial_velocity(c, fixed(:3), fixed(4:))]
        end if
    end subroutine orbit_at

    !> The record at or before a time; 0 when there is none, or none follows within LONGEST_STEP.
    pure integer function interval_at(records, seconds) result(k)
        type(level1_records_t), intent(in) :: records
        integer(i8), intent(in) :: seconds

        k = last_not_after(records%seconds, seconds)
        if (k == records%count) k = 0
        if (k > 0) then
            if (records%seconds(k + 1) - records%seconds(k) > LONGEST_STEP) k = 0
        end if
    end function interval_at

    !> Position and velocity: the cubic through two records.
    pure subroutine state_at(orbit, seconds, fraction, state, ok)
        type(level1_records_t), intent(in) :: orbit     !! At whole seconds
        integer(i8), intent(in) :: seconds
        real(dp), intent(in) :: fraction
        real(dp), intent(out) :: state(6)               !! m, m/s
        logical, intent(out) :: ok

        real(dp) :: h, u, p(3, 2), v(3, 2)
        integer :: k, first

        state = 0
        k = interval_at(orbit, seconds)
        ok = k > 0
        if (.not. ok) return
        first = orbit%field_of('xpos')
        p = transpose(orbit%values(k:k + 1, first:first + 2))
        first = orbit%field_of('xvel')
        v = transpose(orbit%values(k:k + 1, first:first + 2))
        h = real(orbit%seconds(k + 1) - orbit%seconds(k), dp)
        u = (real(seconds - orbit%seconds(k), dp) + fraction)/h
        state(:3) = (1 + 2*u)*(1 - u)**2*p(:, 1) + u*(1 - u)**2*h*v(:, 1) + u**2*(3 - 2*u)*p(:, 2) - u**2*(1 - u)*h*v(:, 2)
        state(4:) = 6*u*(1 - u)*(p(:, 2) - p(:, 1))/h + (1 - u)*(1 - 3*u)*v(:, 1) + u*(3*u - 2)*v(:, 2)
        ok = all(abs(state) < huge(1.0_dp))
    end subroutine state_at

    !> The attitude, between two records by their chord.
    pure subroutine attitude_at(sca1b, seconds, fraction, q, ok)
        type(level1_records_t), intent(in) :: sca1b     !! All fields, at whole seconds
        integer(i8), intent(in) :: seconds              !! GPS, past 2000-01-01 12:00
        real(dp), intent(in) :: fraction                !! s
        real(dp), intent(out) :: q(4)                   !! Inertial to SRF, scalar last
        logical, intent(out) :: ok                      !! It is known

        real(dp) :: pair(4, 2), u
        integer :: i, k, first

        q = 0
        k = interval_at(sca1b, seconds)
        ok = k > 0
        if (.not. ok) return
        first = sca1b%field_of('quatangle')
        do i = 1, 2
            pair(:, i) = gracecg_quaternion(sca1b%values(k + i - 1, first:first + 3))
        end do
        call continuous_quaternions(pair)
        u = (real(seconds - sca1b%seconds(k), dp) + fraction)/real(sca1b%seconds(k + 1) - sca1b%seconds(k), dp)
        q = normalised((1 - u)*pair(:, 1) + u*pair(:, 2))
    end subroutine attitude_at
end module gracecg_level1_frames
