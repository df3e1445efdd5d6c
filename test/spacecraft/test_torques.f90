!> The torque of the gravity gradient.
module test_torques
    use vocabulary
    use gracecg_spacecraft_gravity_gradient_torque, only: gravity_gradient_torque
    implicit none
    private
    public :: collect_torques

    !> CSR-TM-00-01 section 5.2, kg m^2
    real(dp), parameter :: INERTIA(3, 3) = reshape([70.23_dp, -3.0_dp, -2.883_dp, &
                                                    -3.0_dp, 345.14_dp, -0.348_dp, &
                                                    -2.883_dp, -0.348_dp, 388.84_dp], [3, 3])
    real(dp), parameter :: RADIUS = 6837865.0_dp        !! m

contains

    subroutine collect_torques(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('rows-as-printed', test_printed_rows), &
                    new_unittest('sum-over-point-masses', test_point_masses)]
    end subroutine collect_torques

    !> Directions in all octants.
    pure function direction(i) result(c)
        integer, intent(in) :: i
        real(dp) :: c(3)

        c = unit([cos(0.7_dp*i), sin(1.3_dp*i), cos(2.1_dp*i + 0.3_dp)])
    end function direction

    !> CSR-TM-00-01 eq. (2-23) row by row; in the first row I_zx c1 c2 stands for the printed
    !> I_zx c1 c3.
    subroutine test_printed_rows(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: expected(3), c(3)
        integer :: i

        associate (ixx => INERTIA(1, 1), iyy => INERTIA(2, 2), izz => INERTIA(3, 3), &
                   ixy => INERTIA(1, 2), iyz => INERTIA(2, 3), izx => INERTIA(3, 1))
            do i = 1, 20
                c = direction(i)
                expected(1) = (izz - iyy)*c(2)*c(3) + iyz*(c(2)**2 - c(3)**2) + izx*c(1)*c(2) - &
                              ixy*c(3)*c(1)
                expected(2) = (ixx - izz)*c(3)*c(1) + izx*(c(3)**2 - c(1)**2) + ixy*c(2)*c(3) - &
                              iyz*c(2)*c(1)
                expected(3) = (iyy - ixx)*c(2)*c(1) + ixy*(c(1)**2 - c(2)**2) + iyz*c(1)*c(3) - &
                              izx*c(2)*c(3)
                expected = 3*EARTH_GM/RADIUS**3*expected
                call check(error, norm2(gravity_gradient_torque(EARTH_GM, RADIUS, c, INERTIA) - &
                           expected), 0.0_dp, thr=1e-13_dp*norm2(expected))
            end do
        end associate
    end subroutine test_printed_rows

    !> (2-22), the sum of r x F, over three pairs of masses, each pair opposite about the centre of mass.
    !> What the formula leaves out is smaller by (r/R)^2: a fourth of it remains at twice the
    !> distance.
    subroutine test_point_masses(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: near, far

        near = relative_error(500.0_dp)
        far = relative_error(1000.0_dp)
        call check(error, near < 1e-4_dp)
        call check(error, near/far, 4.0_dp, thr=0.01_dp)

    contains

        real(dp) function relative_error(distance)
            real(dp), intent(in) :: distance        !! m
            real(dp), parameter :: PLACES(3, 3) = reshape([1.5_dp, 0.2_dp, -0.1_dp, &
                                                           -0.3_dp, 0.9_dp, 0.2_dp, &
                                                           0.1_dp, -0.4_dp, 0.5_dp], [3, 3])
            real(dp), parameter :: MASSES(3) = [40.0_dp, 70.0_dp, 100.0_dp]
            real(dp) :: tensor(3, 3), torque(3), r(3), c(3)
            integer :: i, side

            c = direction(5)
            tensor = 0
            torque = 0
            do i = 1, 3
                do side = -1, 1, 2
                    r = side*PLACES(:, i)
                    tensor = tensor + MASSES(i)*(dot_product(r, r)*identity(3) - &
                                                 spread(r, 2, 3)*spread(r, 1, 3))
                    torque = torque + cross(r, -MASSES(i)*EARTH_GM*(distance*c + r)/ &
                                            norm2(distance*c + r)**3)
                end do
            end do
            relative_error = norm2(gravity_gradient_torque(EARTH_GM, distance, c, tensor) - &
                                   torque)/ &
                             norm2(torque)
        end function relative_error
    end subroutine test_point_masses
end module test_torques
