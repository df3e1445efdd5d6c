!> Orbit and attitude between the records of GNV1B, GNI1B and SCA1B.
module gracecg_level1_between_records
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_quaternion, only: normalised
    use gracecg_environment_time, only: utc_of_gps
    use gracecg_level1_frames, only: gracecg_quaternion, continuous_quaternions, inertial_of_earth_fixed, &
        inertial_of_earth_fixed_by_states, inertial_velocity
    use gracecg_level1_records, only: level1_records_t
    implicit none
    private
    public :: orbit_at, attitude_at

    integer, parameter :: LONGEST_STEP = 60     !! Between records, s: nothing is known in a longer one

contains

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
end module gracecg_level1_between_records
