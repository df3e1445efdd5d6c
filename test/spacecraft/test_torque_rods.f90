!> The manoeuvre of the torque rods.
module test_torque_rods
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use gracecg_kinds, only: dp
    use gracecg_constants, only: PI
    use gracecg_error, only: error_t, message_of
    use gracecg_torque_rods
    use fixture, only: check_fails, check_passes
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_torque_rods

    !> Field at the start of the report's six cases (front 1-3, back 1-3) in body axes, nT: IGRF at
    !> 1989.0 and the positions and attitudes of CSR-TM-00-01 sections 5.2 and 6.1, rounded
    real(dp), parameter :: FIELD(3, 6) = reshape( &
                           [-24390.0_dp, -3560.0_dp, 7490.0_dp, &
                            2370.0_dp, 640.0_dp, 46320.0_dp, &
                            30210.0_dp, -1330.0_dp, 2310.0_dp, &
                            24510.0_dp, 3640.0_dp, 4830.0_dp, &
                            -420.0_dp, -440.0_dp, 46430.0_dp, &
                            -30120.0_dp, 1140.0_dp, 5890.0_dp], [3, 6])
    !> The patterns the report prints for them
    integer, parameter :: PATTERN(3, 6) = reshape( &
                          [0, 1, 1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 1, 1, 0, -1, 1], [3, 6])

contains

    subroutine collect_torque_rods(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('patterns-of-report', test_report_patterns), &
                    new_unittest('pattern-makes-torques-add', test_torques_add), &
                    new_unittest('general-rule', test_general_rule), &
                    new_unittest('zero-and-undefined-field', test_zero_field), &
                    new_unittest('harmonic-moment', test_harmonic), &
                    new_unittest('several-activations', test_several), &
                    new_unittest('refuses-impossible', test_refuses), &
                    new_unittest('limit-counts-what-is-active', test_limit)]
    end subroutine collect_torque_rods

    !> Up to the common sign, which the report leaves open.
    subroutine test_report_patterns(error)
        type(error_type), allocatable, intent(out) :: error
        integer :: i, ours(3)

        do i = 1, 6
            ours = report_pattern(FIELD(:, i))
            call check(error, all(ours == PATTERN(:, i)) .or. all(ours == -PATTERN(:, i)))
            if (allocated(error)) return
            call check(error, ours(3), 1)
            if (allocated(error)) return
        end do
    end subroutine test_report_patterns

    !> The torque m x B about x is |B_y| + |B_z|, the most that m_y, m_z = +-1 can give.
    subroutine test_torques_add(error)
        type(error_type), allocatable, intent(out) :: error
        integer :: i, m(3)

        do i = 1, 6
            m = report_pattern(FIELD(:, i))
            call check(error, abs(m(2)*FIELD(3, i) - m(3)*FIELD(2, i)), &
                       abs(FIELD(2, i)) + abs(FIELD(3, i)))
            if (allocated(error)) return
        end do
    end subroutine test_torques_add

    !> All orders and signs of three magnitudes.
    subroutine test_general_rule(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ORDERS(3, 6) = reshape( &
                              [1, 2, 3, 1, 3, 2, 2, 1, 3, 2, 3, 1, 3, 1, 2, 3, 2, 1], [3, 6])
        real(dp) :: b(3)
        integer :: k, signs, m(3)

        do k = 1, 6
            do signs = 0, 7
                b(ORDERS(1, k)) = 300*(1 - 2*ibits(signs, 0, 1))
                b(ORDERS(2, k)) = 200*(1 - 2*ibits(signs, 1, 1))
                b(ORDERS(3, k)) = 100*(1 - 2*ibits(signs, 2, 1))
                m = weakest_components_pattern(b)
                call check(error, m(ORDERS(1, k)), 0)
                if (allocated(error)) return
                call check(error, m(ORDERS(3, k)), 1)
                if (allocated(error)) return
                call check(error, m(ORDERS(2, k)), &
                           -nint(sign(1.0_dp, b(ORDERS(2, k))*b(ORDERS(3, k)))))
                if (allocated(error)) return
            end do
        end do
    end subroutine test_general_rule

    !> sign(0) = 0; NaN gives the empty pattern, and the manoeuvre refuses that.
    subroutine test_zero_field(error)
        type(error_type), allocatable, intent(out) :: error
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        real(dp) :: undefined(3)

        call check(error, all(report_pattern([1.0_dp, 0.0_dp, 2.0_dp]) == [0, 0, 1]))
        if (allocated(error)) return
        call check(error, all(weakest_components_pattern([1.0_dp, 1.0_dp, 1.0_dp]) == [0, -1, 1]))
        if (allocated(error)) return
        undefined = ieee_value(1.0_dp, ieee_quiet_nan)
        call check(error, all(report_pattern(undefined) == 0))
        if (allocated(error)) return
        call check(error, all(weakest_components_pattern(undefined) == 0))
        if (allocated(error)) return
        call new_harmonic_manoeuvre(rods, report_pattern(undefined), 30.0_dp, 0.1_dp, 0.0_dp, &
                                    60.0_dp, failure)
        call check_fails(error, message_of(failure), ['pattern'])
    end subroutine test_zero_field

    !> m = [0 1 -1] 30 sin(2 pi 0.1 t) for 60 s.
    subroutine test_harmonic(error)
        type(error_type), allocatable, intent(out) :: error
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        integer :: i

        call new_harmonic_manoeuvre(rods, [0, 1, -1], 30.0_dp, 0.1_dp, 0.0_dp, 60.0_dp, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        do i = 0, 600
            call check(error, maxval(abs(dipole_moment(rods, i/10.0_dp) - &
                                         [0, 1, -1]*30*sin(2*PI*0.1_dp*i/10))) < 1e-12_dp)
            if (allocated(error)) return
        end do
        call check(error, maxval(abs(dipole_moment(rods, 2.5_dp) - [0, 30, -30])) < 1e-13_dp)
        if (allocated(error)) return
        call check(error, maxval(abs(dipole_moment(rods, -0.1_dp))), 0.0_dp)
        if (allocated(error)) return
        call check(error, maxval(abs(dipole_moment(rods, 62.5_dp))), 0.0_dp)
    end subroutine test_harmonic

    !> Activations of one rod add up; phase and start count; frequency 0 with phase pi/2 is
    !> constant.
    subroutine test_several(error)
        type(error_type), allocatable, intent(out) :: error
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure

        call new_torque_rods(rods, &
                             [rod_activation_t(1, 10.0_dp, 0.1_dp, 0.3_dp, 5.0_dp, 25.0_dp), &
                              rod_activation_t(1, -4.0_dp, 0.25_dp, 0.0_dp, 0.0_dp, 20.0_dp), &
                              rod_activation_t(3, 7.0_dp, 0.0_dp, PI/2, 10.0_dp, 12.0_dp)], &
                             failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, maxval(abs(dipole_moment(rods, 11.0_dp) - &
                                     [10*sin(0.2_dp*PI*6 + 0.3_dp) - 4*sin(0.5_dp*PI*11), &
                                      0.0_dp, 7.0_dp])) < 1e-13_dp)
        if (allocated(error)) return
        call check(error, maxval(abs(dipole_moment(rods, 22.0_dp) - &
                                     [10*sin(0.2_dp*PI*17 + 0.3_dp), 0.0_dp, 0.0_dp])) < 1e-13_dp)
    end subroutine test_several

    subroutine test_refuses(error)
        type(error_type), allocatable, intent(out) :: error
        type(rod_activation_t) :: good, bad

        good = rod_activation_t(2, 1.0_dp, 0.1_dp, 0.0_dp, 0.0_dp, 60.0_dp)
        bad = good
        bad%axis = 4
        call check_refused(error, [good, bad], 'activation 2: axis = 4')
        if (allocated(error)) return
        bad = good
        bad%amplitude = ieee_value(1.0_dp, ieee_quiet_nan)
        call check_refused(error, [bad], 'finite')
        if (allocated(error)) return
        bad = good
        bad%frequency = -0.1_dp
        call check_refused(error, [bad], 'frequency')
        if (allocated(error)) return
        bad = good
        bad%stop = 0
        call check_refused(error, [bad], 'stop')
        if (allocated(error)) return
        bad = good
        bad%amplitude = -31
        call check_refused(error, [bad], 'torque rod 2')
        if (allocated(error)) return
        call check_refused(error, spread(good, 1, MAX_ACTIVATIONS + 1), '17 activations')
    end subroutine test_refuses

    !> 20 and 15 A m^2 on one rod are too much together, not one after the other nor on two rods.
    subroutine test_limit(error)
        type(error_type), allocatable, intent(out) :: error
        type(rod_activation_t) :: pair(2)
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure

        pair = rod_activation_t(1, 20.0_dp, 0.1_dp, 0.0_dp, 0.0_dp, 30.0_dp)
        pair(2)%amplitude = 15
        pair(2)%start = 20
        pair(2)%stop = 50
        call check_refused(error, pair, '35 A m^2 at t = 20 s')
        if (allocated(error)) return
        call check_refused(error, pair([2, 1]), '35 A m^2')
        if (allocated(error)) return
        pair(2)%start = 31
        call new_torque_rods(rods, pair, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        pair(2)%start = 20
        pair(2)%axis = 2
        call new_torque_rods(rods, pair, failure)
        call check_passes(error, message_of(failure))
    end subroutine test_limit

    subroutine check_refused(error, activations, part_of_message)
        type(error_type), allocatable, intent(out) :: error
        type(rod_activation_t), intent(in) :: activations(:)
        character(*), intent(in) :: part_of_message

        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure

        call new_torque_rods(rods, activations, failure)
        call check_fails(error, message_of(failure), [part_of_message])
    end subroutine check_refused
end module test_torque_rods
