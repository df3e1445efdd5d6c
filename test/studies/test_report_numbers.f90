!> What the report prints beside its large tables: the budget of the centre of mass and the limits of its
!> axes; and the gravity gradient of its Figure 3.1.
module test_report_numbers
    use vocabulary
    use calibrations
    use gracecg_files_data_table, only: data_table_t
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_simulation_dynamics, only: POSITION, VELOCITY, ATTITUDE
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t
    use gracecg_studies_published
    use gracecg_studies_published
    use gracecg_studies_gravity_gradient
    implicit none
    private
    public :: collect_report_numbers

contains

    subroutine collect_report_numbers(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('com-budget', test_budget), &
                    new_unittest('printed-axes', test_axes), &
                    new_unittest('gradient-by-differences', test_gradient), &
                    new_unittest('gradient-of-a-sphere', test_sphere)]
    end subroutine collect_report_numbers

    !> The RSS as printed, but for x of Table 1.1, where 0.28 must stand; what is printed "---" is empty.
    subroutine test_budget(error)
        type(error_type), allocatable, intent(out) :: error
        type(data_table_t) :: table
        type(string_t), allocatable :: lines(:)
        type(error_t), allocatable :: failure
        integer :: i, k, empty

        call check(error, all(abs(rss_of_effects('1.1') - [0.28_dp, 0.23_dp, 0.24_dp]) <= 0.005_dp))
        call check(error, all(abs(rss_of_effects('1.2') - [0.0462_dp, 0.0007_dp, 0.0007_dp]) &
                                                          <= 0.00005_dp) .and. all(abs(rss_of_effects('9.9')) <= 0))
        table = com_budget_table()
        call table%csv(lines, failure)
        if (failed(error, failure)) return
        call check(error, size(lines), 1 + 12 + 3 + 2*3)
        empty = 0
        do i = 2, 13
            associate (line => lines(i)%text//',')
                empty = empty + count([(line(k:k + 1) == ',,', k=1, len(line) - 1)])
            end associate
        end do
        call check(error, empty, 10, 'printed ---')
        call check(error, lines(14)%text, '1.1,rss,0.27,0.23,0.24')
        call check(error, index(lines(15)%text, '1.1,rss of the effects,0.28') == 1)
        call check(error, lines(16)%text, '1.1,requirement,0.5,0.5,0.5')
        call check(error, lines(9)%text, '1.1,Moisture release CFRP - mass decrease,,,0.038')
        call check(error, lines(22)%text, '1.2,requirement,0.1,0.1,0.1')
    end subroutine test_budget

    subroutine test_axes(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, all(abs(limits_of('6.2', 'front', 'assest-rde', 'z') - [-7e-4_dp, -3e-4_dp]) < 1e-15_dp))
        call check(error, all(abs(limits_of('6.4', 'back', 'acceleration', 'all') - [0.0_dp, 2.5e-5_dp]) < 1e-15_dp))
        call check(error, all(abs(limits_of('6.5', 'front', 'ascfest', 'y') - [0.0_dp, 6e-5_dp]) < 1e-15_dp))
        call check(error, all(abs(published_axis('6.6', 'back', 'ascfest', 'y')) <= 0), 'no such panel')

    contains

        function limits_of(figure, satellite, panel, axis) result(limits)
            character(*), intent(in) :: figure, satellite, panel, axis
            real(dp) :: limits(2), found(3)

            found = published_axis(figure, satellite, panel, axis)
            limits = found(:2)
        end function limits_of
    end subroutine test_axes

    subroutine fly(model, orbit)
        character(*), intent(in) :: model           !! Of gravity
        type(nominal_orbit_t), intent(out) :: orbit
        type(case_t) :: case

        call take_case('front-1', case)
        case%gravity_model = model
        call make_orbit(case, orbit)
    end subroutine fly

    !> The sum of both parts is the difference of gravitation at the proof mass and the centre of mass, (3-4),
    !> here by central differences over 200 m.
    subroutine test_gradient(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: OFFSET(3) = [0.5e-3_dp, -0.7e-3_dp, 0.3e-3_dp], REACH = 1e5_dp
        type(nominal_orbit_t) :: orbit
        type(gradient_sample_t), allocatable :: samples(:)
        real(dp) :: fixed(3, 3), r(3), v(3), d(3), ahead(3), behind(3), expected(3), radial(3), normal(3)
        integer :: i, k

        call fly('egm96', orbit)
        allocate (samples, source=gradient_along_orbit(orbit, OFFSET, 500))
        call check(error, size(samples) == 12)
        do i = 1, size(samples)
            k = nint(samples(i)%time)
            r = orbit%state(POSITION, k)
            v = orbit%state(VELOCITY, k)
            fixed = orbit%dynamics%earth%from_inertial(samples(i)%time)
            d = matmul(fixed, matmul(OFFSET, rotation_matrix(orbit%state(ATTITUDE, k))))
            call orbit%dynamics%gravity%acceleration(matmul(fixed, r) + REACH*d, ahead)
            call orbit%dynamics%gravity%acceleration(matmul(fixed, r) - REACH*d, behind)
            d = -matmul(ahead - behind, fixed)/(2*REACH)
            radial = r/norm2(r)
            normal = [r(2)*v(3) - r(3)*v(2), r(3)*v(1) - r(1)*v(3), r(1)*v(2) - r(2)*v(1)]
            normal = normal/norm2(normal)
            expected(1) = dot_product(d, radial)
            expected(3) = dot_product(d, normal)
            expected(2) = dot_product(d, v - dot_product(v, radial)*radial)/norm2(v - dot_product(v, radial)*radial)
            call check(error, maxval(abs(samples(i)%central + samples(i)%others - expected)) < &
                       1e-6_dp*maxval(abs(expected)))
        end do
    end subroutine test_gradient

    !> For a point mass (3-6) holds, and nothing is left for the other terms. (3-4) as printed, without the minus and
    !> the transpose of M, does not give it: M G M^T d with the minus does, neither M G d nor -M G d.
    subroutine test_sphere(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: OFFSET(3) = [1e-3_dp, 2e-3_dp, -1e-3_dp]
        type(nominal_orbit_t) :: orbit
        type(gradient_sample_t), allocatable :: samples(:)
        real(dp) :: d(3), u(3), expected(3), m(3, 3), g(3, 3), body(3)
        integer :: i, k

        call fly('point-mass', orbit)
        allocate (samples, source=gradient_along_orbit(orbit, OFFSET, 1000))
        do i = 1, size(samples)
            k = nint(samples(i)%time)
            d = matmul(OFFSET, rotation_matrix(orbit%state(ATTITUDE, k)))
            u = orbit%state(POSITION, k)/norm2(orbit%state(POSITION, k))
            expected = EARTH_GM/norm2(orbit%state(POSITION, k))**3*(d - 3*dot_product(u, d)*u)
            call check(error, abs(samples(i)%central(1) - dot_product(expected, u)) < 1e-12_dp*norm2(expected), 'radial')
            call check(error, abs(norm2(samples(i)%central) - norm2(expected)) < 1e-12_dp*norm2(expected), 'length')
            call check(error, maxval(abs(samples(i)%others)) < 1e-12_dp*norm2(expected), 'others')
            m = rotation_matrix(orbit%state(ATTITUDE, k))
            body = matmul(m, expected)
            g = EARTH_GM/norm2(orbit%state(POSITION, k))**3*(3*spread(u, 2, 3)*spread(u, 1, 3) - identity(3))
            call check(error, norm2(-matmul(m, matmul(g, d)) - body) < 1e-12_dp*norm2(body), '(3-4), corrected')
            call check(error, min(norm2(matmul(m, matmul(g, OFFSET)) - body), norm2(-matmul(m, matmul(g, OFFSET)) - body), &
                                  norm2(matmul(m, matmul(g, d)) - body)) > 0.1_dp*norm2(body), '(3-4), as printed')
        end do
    end subroutine test_sphere
end module test_report_numbers
