!> Mass properties: parallel axes, centre of gravity, and what is refused.
module test_mass_properties
    use vocabulary
    use gracecg_spacecraft_mass_properties
    implicit none
    private
    public :: collect_mass_properties

    !> CSR-TM-00-01 section 5.2, kg m^2
    real(dp), parameter :: REPORT_INERTIA(3, 3) = reshape( &
                           [70.23_dp, -3.0_dp, -2.883_dp, &
                            -3.0_dp, 345.14_dp, -0.348_dp, &
                            -2.883_dp, -0.348_dp, 388.84_dp], [3, 3])

    !> Five point masses: a body with nothing symmetric about it, kg and m
    real(dp), parameter :: POINT_MASS(5) = [60.0_dp, 90.0_dp, 110.0_dp, 70.0_dp, 90.0_dp]
    real(dp), parameter :: POINT(3, 5) = reshape( &
                           [1.1_dp, 0.2_dp, -0.3_dp, -0.9_dp, 0.5_dp, 0.1_dp, &
                            0.3_dp, -0.7_dp, 0.2_dp, -0.2_dp, 0.4_dp, 0.6_dp, &
                            0.1_dp, 0.3_dp, -0.5_dp], [3, 5])

contains

    subroutine collect_mass_properties(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('parallel-axes', test_parallel_axes), &
                    new_unittest('parallel-axes-of-report', test_report_inertia), &
                    new_unittest('inverse-inertia-of-the-fit', test_inverse_inertia), &
                    new_unittest('centre-of-gravity-of-report', test_report_gravity), &
                    new_unittest('centre-of-gravity-of-points', test_point_gravity), &
                    new_unittest('accepts-report-and-refuses-impossible', test_accepts)]
    end subroutine collect_mass_properties

    pure function inertia_of_points(origin) result(inertia)
        real(dp), intent(in) :: origin(3)
        real(dp) :: inertia(3, 3)

        real(dp) :: r(3)
        integer :: i, j

        inertia = 0
        do i = 1, size(POINT_MASS)
            r = POINT(:, i) - origin
            inertia = inertia + POINT_MASS(i)*dot_product(r, r)*identity(3)
            do j = 1, 3
                inertia(:, j) = inertia(:, j) - POINT_MASS(i)*r*r(j)
            end do
        end do
    end function inertia_of_points

    pure function centre_of_points() result(centre)
        real(dp) :: centre(3)

        centre = matmul(POINT, POINT_MASS)/sum(POINT_MASS)
    end function centre_of_points

    !> Inertia by direct sums (2-17) about the proof mass and about the centre of mass.
    subroutine test_parallel_axes(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: OFFSET(3) = [0.3_dp, -0.2_dp, 0.5_dp]
        type(mass_properties_t) :: body

        body%mass = sum(POINT_MASS)
        body%com_to_pmc = OFFSET
        body%inertia_pmc = inertia_of_points(centre_of_points() + OFFSET)
        call check(error, maxval(abs(inertia_about_com(body) - &
                                     inertia_of_points(centre_of_points()))) < 1e-12_dp)
    end subroutine test_parallel_axes

    !> CSR-TM-00-01 eq. (2-18) element by element.
    subroutine test_report_inertia(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: MASS = 420.0_dp, D(3) = [3e-4_dp, 4e-4_dp, -5e-4_dp]
        type(mass_properties_t) :: body
        real(dp) :: printed(3, 3)

        body = mass_properties_t(MASS, REPORT_INERTIA, D)
        printed(1, :) = [D(2)**2 + D(3)**2, -D(1)*D(2), -D(1)*D(3)]
        printed(2, :) = [-D(1)*D(2), D(1)**2 + D(3)**2, -D(2)*D(3)]
        printed(3, :) = [-D(1)*D(3), -D(2)*D(3), D(1)**2 + D(2)**2]
        call check(error, maxval(abs(inertia_about_com(body) - &
                                     (REPORT_INERTIA - MASS*printed))) < 1e-13_dp)
    end subroutine test_report_inertia

    !> J = J_p + dJ, (4-2), (4-3), and the inverse that the estimators use, (4-4)-(4-6): what J_p^-1 lacks is
    !> 2 to 3 parts in a million, and the series with one more term lacks the square of that.
    subroutine test_inverse_inertia(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: D(3) = [3e-4_dp, 4e-4_dp, -5e-4_dp]
        real(dp) :: change(3, 3), inverse(3, 3), inverse_p(3, 3), first(3, 3)

        inverse_p = inverse_3x3(REPORT_INERTIA)
        inverse = inverse_3x3(inertia_about_com(mass_properties_t(420.0_dp, REPORT_INERTIA, D)))
        change = -420.0_dp*(dot_product(D, D)*identity(3) - spread(D, 2, 3)*spread(D, 1, 3))
        first = matmul(inverse_p, change)
        call check(error, norm2(first) > 2e-6_dp .and. norm2(first) < 3e-6_dp, 'size of dJ')
        call check(error, maxval(abs(inverse_3x3(matmul(inverse_3x3(identity(3) + first), inverse_p)) - &
                                     (REPORT_INERTIA + change))) < 1e-11_dp, '(4-4)')
        call check(error, norm2(inverse - inverse_p) < 3e-6_dp*norm2(inverse_p), '(4-6)')
        inverse = inverse - inverse_p + matmul(first, inverse_p)
        call check(error, norm2(inverse) < 1e-11_dp*norm2(inverse_p), '(4-5)')
    end subroutine test_inverse_inertia

    !> CSR-TM-00-01 eqs. (2-33)-(2-35), alpha_3 = pi: 9.68e-8 m, towards the Earth's far side (minus z).
    subroutine test_report_gravity(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: inertia(3, 3), offset(3)

        inertia = 0
        inertia(1, 1) = 70
        inertia(2, 2) = 340
        inertia(3, 3) = 390
        offset = centre_of_gravity_offset(420.0_dp, inertia, [0.0_dp, 0.0_dp, -1.0_dp], 6828e3_dp)
        call check(error, maxval(abs(offset - [0.0_dp, 0.0_dp, -9.68e-8_dp])) < 5e-11_dp)
    end subroutine test_report_gravity

    !> (2-33), (2-34): the place, from the centre of mass (2-32), where the whole mass would be attracted as
    !> the point masses are, from their
    !> summed attraction; near a small planet, so that the sums keep enough digits. The rest falls
    !> off as the next power of size over radius.
    subroutine test_point_gravity(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: difference(2)
        integer :: i

        do i = 1, 2
            difference(i) = gravity_difference(1e4_dp*2**i)
        end do
        call check(error, difference(1) < 2e-8_dp)
        call check(error, difference(1)/difference(2), 4.0_dp, thr=0.5_dp)
    end subroutine test_point_gravity

    real(dp) function gravity_difference(radius) result(difference)
        real(dp), intent(in) :: radius      !! m
        real(dp) :: radial(3), force(3), centre(3), place(3), r(3), offset(3)
        integer :: i

        radial = unit([0.5_dp, -0.7_dp, 0.4_dp])
        centre = centre_of_points()
        force = 0
        do i = 1, size(POINT_MASS)
            r = radius*radial + POINT(:, i) - centre
            force = force - EARTH_GM*POINT_MASS(i)*r/norm2(r)**3
        end do
        place = -unit(force)*sqrt(EARTH_GM*sum(POINT_MASS)/norm2(force))
        offset = centre_of_gravity_offset(sum(POINT_MASS), inertia_of_points(centre), radial, &
                                          radius)
        difference = norm2(place - radius*radial - offset)
    end function gravity_difference

    subroutine test_accepts(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: D(3) = 1e-4_dp, M = 420
        type(error_t), allocatable :: failure
        real(dp) :: inertia(3, 3)

        call validate_mass_properties( &
            mass_properties_t(420.0_dp, REPORT_INERTIA, [3e-4_dp, 4e-4_dp, -5e-4_dp]), failure)
        call check_passes(error, failure)
        call check_refused(error, mass_properties_t(0.0_dp, REPORT_INERTIA, D), 'mass')
        call check_refused(error, mass_properties_t(nan, REPORT_INERTIA, D), 'mass')
        call check_refused(error, mass_properties_t(M, REPORT_INERTIA, D*nan), 'com_to_pmc')
        call check_refused(error, mass_properties_t(M, REPORT_INERTIA*nan, D), 'finite')
        inertia = REPORT_INERTIA
        inertia(1, 2) = 3
        call check_refused(error, mass_properties_t(M, inertia, D), 'not symmetric')
        inertia = REPORT_INERTIA
        inertia(3, 3) = -1
        call check_refused(error, mass_properties_t(M, inertia, D), 'not positive definite')
        inertia = REPORT_INERTIA
        inertia(3, 3) = 420
        call check_refused(error, mass_properties_t(M, inertia, D), 'no body')
        call check_refused(error, mass_properties_t(M, REPORT_INERTIA, 10000*D), 'shifted')
    end subroutine test_accepts

    subroutine check_refused(error, body, part_of_message)
        type(error_type), allocatable, intent(inout) :: error
        type(mass_properties_t), intent(in) :: body
        character(*), intent(in) :: part_of_message
        type(error_t), allocatable :: failure

        call validate_mass_properties(body, failure)
        call check_fails(error, failure, part_of_message)
    end subroutine check_refused
end module test_mass_properties
