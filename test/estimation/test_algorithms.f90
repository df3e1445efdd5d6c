!> The reduced state and the combined problems: partials against differences, and the agreement of the
!> four estimators.
module test_algorithms
    use vocabulary
    use calibrations
    use gracecg_base_vectors, only: cross_matrix
    use gracecg_base_quaternion, only: normalised, rotation_matrix, quaternion_of_matrix, quaternion_product, &
        rotation_angle_between
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_attitude_fit, only: attitude_fit_t, fitted_rotation_t, new_attitude_fit
    use gracecg_estimation_report_problem, only: report_problem_t, prepare_problem, small_angles, small_rotation
    use test_estimators, only: example, OFFSET, DRIFT, BIAS, OMEGA_0, Q_0
    implicit none
    private
    public :: collect_algorithms

contains

    subroutine collect_algorithms(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('small-angles-and-rotation-are-inverse', test_small_angles), &
                    new_unittest('small-turns-as-quaternions', test_small_turns), &
                    new_unittest('reduced-transition-against-differences', test_reduced_transition), &
                    new_unittest('full-combined-partials-against-differences', test_full_partials), &
                    new_unittest('reduced-combined-partials-against-differences', test_reduced_partials), &
                    new_unittest('all-agree-on-the-reports-cases', test_agreement), &
                    new_unittest('all-converge-on-a-long-arc', test_long_arc)]
    end subroutine collect_algorithms

    !> Turns about x, y, z one after the other: (4-62) for the sequence 3-2-1. For small angles
    !> the matrix is I - Pi(u), and (4-70) gives its elements.
    subroutine test_small_angles(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: u(3), product(3, 3), c(3, 3)
        integer :: i

        do i = 1, 20
            u = 1.4_dp*[cos(0.7_dp*i), sin(1.3_dp*i), cos(2.1_dp*i + 0.3_dp)]
            product = matmul(turn(1, u(1)), matmul(turn(2, u(2)), turn(3, u(3))))
            c = small_rotation(u)
            call check(error, maxval(abs(c - product)) < 1e-15_dp, '(4-62)')
            call check(error, maxval(abs(matmul(c, transpose(c)) - identity(3))) < 1e-15_dp)
            call check(error, maxval(abs(small_angles(c) - u)) < 1e-14_dp, 'inverse')
            u = 1e-5_dp*u
            call check(error, maxval(abs(small_rotation(u) - (identity(3) - cross_matrix(u)))) < 1e-9_dp)
            c = identity(3) - cross_matrix(u)
            call check(error, maxval(abs(small_angles(c) - [c(2, 3), -c(1, 3), c(1, 2)])) < 1e-9_dp, '(4-70)')
        end do
    end subroutine test_small_angles

    !> The quaternion of small angles that the report prints, (4-63), (4-68), (4-69), is that of C(zeta),
    !> (4-61), but for squares of the angles: ten times smaller angles, a hundred times smaller difference.
    subroutine test_small_turns(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: ZETA(3) = [1e-3_dp, -2e-3_dp, 1.5e-3_dp]

        call check(error, difference(ZETA) < norm2(ZETA)**2)
        call check(error, difference(ZETA)/difference(ZETA/10), 100.0_dp, thr=0.5_dp)

    contains

        !> The angle between both, rad.
        pure real(dp) function difference(angles)
            real(dp), intent(in) :: angles(3)
            real(dp) :: printed(4)

            printed = quaternion_product([angles/2, 1.0_dp]/sqrt(1 + norm2(angles)**2/4), normalised(Q_0))
            difference = rotation_angle_between(turned(normalised(Q_0), angles), printed)
        end function difference
    end subroutine test_small_turns

    !> Passive rotation about one axis.
    pure function turn(axis, angle) result(r)
        integer, intent(in) :: axis
        real(dp), intent(in) :: angle       !! rad
        real(dp) :: r(3, 3)
        integer :: next, last

        next = mod(axis, 3) + 1
        last = mod(next, 3) + 1
        r = identity(3)
        r(next, next) = cos(angle)
        r(last, last) = cos(angle)
        r(next, last) = sin(angle)
        r(last, next) = -sin(angle)
    end function turn

    !> Small turns and changes of rate at the epoch, and what became of them after a minute: (4-58)-(4-61),
    !> (4-64)-(4-67), (4-73).
    subroutine test_reduced_transition(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: STEP(6) = [1e-5_dp, 1e-5_dp, 1e-5_dp, 1e-7_dp, 1e-7_dp, 1e-7_dp]
        type(observation_set_t) :: observations
        type(fitting_data_t) :: data
        type(attitude_fit_t) :: fit
        type(fitted_rotation_t) :: nominal, changed
        type(error_t), allocatable :: failure
        real(dp) :: change(6), angles(3, 2), found(3), transition(3, 6)
        integer :: i, side, n

        call example(observations)
        call preprocess(observations, estimation_options_t(), data, failure)
        if (failed(error, failure)) return
        fit = new_attitude_fit(observations%knowledge%inertia, data%interval, data%torque)
        n = fit%steps
        call fit%integrate(normalised(Q_0), OMEGA_0, nominal)
        transition = nominal%angle_transition(n)
        do i = 1, 6
            do side = 1, 2
                change = 0
                change(i) = merge(STEP(i), -STEP(i), side == 1)
                call fit%integrate(turned(normalised(Q_0), change(:3)), OMEGA_0 + change(4:), changed)
                angles(:, side) = small_angles(matmul(rotation_matrix(normalised(changed%q(:, n))), &
                                                      transpose(rotation_matrix(normalised(nominal%q(:, n))))))
            end do
            found = transition(:, i)
            call check(error, maxval(abs((angles(:, 1) - angles(:, 2))/(2*STEP(i)) - found)) < &
                       1e-7_dp*maxval(abs(found)))
        end do
    end subroutine test_reduced_transition

    !> The attitude after a turn by small angles: C(zeta) R(q).
    pure function turned(q, zeta) result(q_turned)
        real(dp), intent(in) :: q(4), zeta(3)
        real(dp) :: q_turned(4)

        q_turned = quaternion_of_matrix(matmul(small_rotation(zeta), rotation_matrix(q)))
        if (dot_product(q, q_turned) < 0) q_turned = -q_turned
    end function turned

    !> (4-17)-(4-26), (4-46), (4-49), (4-52), (4-57), (4-83)-(4-91).
    subroutine test_full_partials(error)
        type(error_type), allocatable, intent(out) :: error

        call check_partials(error, .false.)
    end subroutine test_full_partials

    !> (4-60), (4-69), (4-71)-(4-74), (4-92)-(4-102).
    subroutine test_reduced_partials(error)
        type(error_type), allocatable, intent(out) :: error

        call check_partials(error, .true.)
    end subroutine test_reduced_partials

    !> Residuals change by minus the partials times a change of the state. The nominal state is the
    !> true one: only there are angles of rotations additive.
    subroutine check_partials(error, reduced)
        type(error_type), allocatable, intent(inout) :: error
        logical, intent(in) :: reduced
        type(report_problem_t) :: nominal, changed
        type(observation_set_t) :: observations
        type(fitting_data_t) :: data
        type(estimation_options_t) :: options
        type(error_t), allocatable :: failure
        real(dp), allocatable :: partials(:, :), unused(:, :), residuals(:, :), weights(:), differences(:)
        real(dp) :: step
        integer :: i, side, n

        call example(observations, interval=0.5_dp)
        options%guess_quaternion = normalised(Q_0)
        options%guess_angular_velocity = OMEGA_0
        options%guess_offset = OFFSET
        call preprocess(observations, options, data, failure)
        if (failed(error, failure)) return
        call prepare_problem(observations%knowledge, options, data, reduced, nominal)
        call nominal%choose(attitude=.true., offset=.true.)
        nominal%offset_state(4:6) = DRIFT
        nominal%offset_state(7:9) = BIAS
        n = nominal%attitude_parameters + 9
        allocate (partials(n, nominal%observations), residuals(nominal%observations, 2), &
                  weights(nominal%observations))
        unused = partials
        call nominal%linearise(partials, residuals(:, 1), weights, failure)
        if (failed(error, failure)) return
        call check(error, maxval(abs(residuals(:nominal%attitude_observations, 1))) < 1e-12_dp)
        call check(error, maxval(abs(residuals(nominal%attitude_observations + 1:, 1))) < 1e-15_dp)
        do i = 1, n
            step = 1e-4_dp*nominal%scales(i)
            do side = 1, 2
                changed = nominal
                call change_state(changed, i, merge(step, -step, side == 1))
                call changed%linearise(unused, residuals(:, side), weights, failure)
            end do
            differences = (residuals(:, 2) - residuals(:, 1))/(2*step)
            associate (last => nominal%attitude_observations)
                call check_row(error, partials(i, :last), differences(:last), &
                               trim(nominal%names(i))//', attitude')
                call check_row(error, partials(i, last + 1:), differences(last + 1:), &
                               trim(nominal%names(i))//', accelerometer')
            end associate
        end do
    end subroutine check_partials

    !> Partials of one parameter against differences; none means none.
    subroutine check_row(error, partials, differences, name)
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in) :: partials(:), differences(:)
        character(*), intent(in) :: name

        call check(error, maxval(abs(differences - partials)) <= 1e-5_dp*maxval(abs(partials)), name)
    end subroutine check_row

    !> Adds to one parameter of a combined problem; a quaternion is not normalised again.
    subroutine change_state(problem, parameter, amount)
        type(report_problem_t), intent(inout) :: problem
        integer, intent(in) :: parameter
        real(dp), intent(in) :: amount
        real(dp) :: zeta(3)
        integer :: n

        n = problem%components
        if (parameter > n + 3) then
            problem%offset_state(parameter - n - 3) = problem%offset_state(parameter - n - 3) + amount
        else if (parameter > n) then
            problem%angular_velocity(parameter - n) = problem%angular_velocity(parameter - n) + amount
        else if (problem%reduced) then
            zeta = 0
            zeta(parameter) = amount
            problem%quaternion = turned(problem%quaternion, zeta)
        else
            problem%quaternion(parameter) = problem%quaternion(parameter) + amount
        end if
    end subroutine change_state

    !> In five minutes the torque that the operator does not know turns the satellite so far that the
    !> full state's quaternion, left to least squares, would be shorter than 1.
    subroutine test_long_arc(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(estimation_options_t) :: options
        integer :: a

        options%test_beliefs = .false.          ! other torques change over five minutes: told, and not the matter here
        call take_case('front-1', case)
        case%duration = 300
        case%satellite%rods%activations%stop = 300
        call make_observations(case, 3, 1, observations, only_used_head=.true.)
        do a = 1, size(REPORT_ESTIMATORS)
            if (estimate_fails(error, trim(REPORT_ESTIMATORS(a)), observations, options, solution)) return
            call check(error, solution%converged, REPORT_ESTIMATORS(a))
        end do
    end subroutine test_long_arc

    !> With the report's weights the star camera alone decides on the attitude, so all four give the
    !> same offset.
    subroutine test_agreement(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: first, other
        integer :: i, a

        do i = 1, size(REPORT_CASE_NAMES)
            call make_observations(REPORT_CASE_NAMES(i), 3, 1, observations, only_used_head=.true.)
            if (estimate_fails(error, REPORT_ESTIMATORS(1), observations, estimation_options_t(), first)) return
            do a = 2, size(REPORT_ESTIMATORS)
                if (estimate_fails(error, trim(REPORT_ESTIMATORS(a)), observations, estimation_options_t(), &
                                   other)) return
                call check(error, other%converged, REPORT_CASE_NAMES(i)//', '//REPORT_ESTIMATORS(a))
                call check(error, maxval(abs(other%offset - first%offset)), 0.0_dp, &
                           REPORT_CASE_NAMES(i)//', '//REPORT_ESTIMATORS(a), thr=1e-9_dp)
                call check(error, maxval(abs(other%covariance/first%covariance - 1)) < 1e-3_dp, 'covariance')
            end do
        end do
    end subroutine test_agreement
end module test_algorithms
