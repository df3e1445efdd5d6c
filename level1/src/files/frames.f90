!> The frames of Level-1 data: AF of the accelerometer, those of the star cameras' heads, SRF (the body axes),
!> Earth-fixed and inertial axes.
module gracecg_level1_frames
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: EARTH_ROTATION_RATE
    use gracecg_base_vectors, only: cross
    use gracecg_base_quaternion, only: quaternion_product, normalised
    use gracecg_environment_earth_orientation, only: earth_orientation_t, earth_parameters_t, iau_orientation
    use gracecg_environment_time, only: utc_t
    use gracecg_level1_records, only: level1_records_t
    implicit none
    private
    public :: srf_of_accelerometer, signed_axes_valid, gracecg_quaternion, continuous_quaternions
    public :: mounting_of_head, attitude_by_head, calibration_vector
    public :: inertial_of_earth_fixed_by_states, inertial_of_earth_fixed, inertial_velocity
    public :: ACCELEROMETER_AXES

    !> Which axis of AF, with its sign, x, y and z of SRF are: z, x, y (ACC1A of GRACE-FO against ACT1B)
    integer, parameter :: ACCELEROMETER_AXES(3) = [3, 1, 2]

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
end module gracecg_level1_frames
