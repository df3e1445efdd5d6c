!> The gravity of the Earth: a point mass, or spherical harmonics of the geopotential.
!>
!> Positions and results are in the Earth-fixed frame (z along the axis of rotation, x in the
!> meridian of Greenwich).
module gracecg_environment_geopotential
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM
    use gracecg_base_error, only: error_t, fail, fail_out_of_range, number_text
    use gracecg_base_text, only: integer_text
    use gracecg_environment_spherical_harmonics, only: MAX_DEGREE, harmonic_function_t, &
        new_harmonic_function
    use gracecg_environment_table_egm96, only: EGM96_DEGREE, EGM96_GM, EGM96_RADIUS, EGM96_C, EGM96_S
    implicit none
    private
    public :: gravity_model_t, point_mass_gravity_t, geopotential_t, new_geopotential, egm96
    public :: check_degree_and_order

    type, abstract :: gravity_model_t
        !! Any gravity field; evaluation is undefined at the centre
    contains
        procedure(acceleration_interface), deferred :: acceleration !! Gradient of the potential
        procedure(potential_interface), deferred :: potential       !! Positive, zero at infinity
        procedure(gradient_tensor_interface), deferred :: gradient_tensor
        !! Second derivatives of the potential
        procedure :: all_derivatives => derivatives_one_by_one      !! The three of them at a place
        procedure :: accelerations => accelerations_one_by_one      !! At many places, with the potential if wanted
    end type gravity_model_t

    abstract interface
        !> The gravitational acceleration: the gradient of the potential.
        pure subroutine acceleration_interface(self, position, a)
            import :: gravity_model_t, dp
            class(gravity_model_t), intent(in) :: self
            real(dp), intent(in) :: position(3)     !! Earth-fixed, m
            real(dp), intent(out) :: a(3)           !! Earth-fixed, m/s^2
        end subroutine acceleration_interface

        !> The gravitational potential: positive, zero at infinity.
        pure subroutine potential_interface(self, position, u)
            import :: gravity_model_t, dp
            class(gravity_model_t), intent(in) :: self
            real(dp), intent(in) :: position(3)     !! Earth-fixed, m
            real(dp), intent(out) :: u              !! m^2/s^2
        end subroutine potential_interface

        !> The second derivatives of the potential.
        pure subroutine gradient_tensor_interface(self, position, tensor)
            import :: gravity_model_t, dp
            class(gravity_model_t), intent(in) :: self
            real(dp), intent(in) :: position(3)     !! Earth-fixed, m
            real(dp), intent(out) :: tensor(3, 3)   !! Earth-fixed, 1/s^2
        end subroutine gradient_tensor_interface
    end interface

    type, extends(gravity_model_t) :: point_mass_gravity_t
        !! U = mu/r
        real(dp) :: mu = EARTH_GM   !! m^3/s^2
    contains
        procedure :: acceleration => point_mass_acceleration
        procedure :: potential => point_mass_potential
        procedure :: gradient_tensor => point_mass_gradient_tensor
    end type point_mass_gravity_t

    type, extends(gravity_model_t) :: geopotential_t
        !! Spherical harmonics, CSR-TM-00-01 eq. (2-2); made by egm96, read_gfc or new_geopotential
        character(:), allocatable :: name                       !! Of the model, for output
        integer :: degree = 0                                   !! Up to which the sum goes
        integer :: order = 0                                    !! Up to which the sum goes, 0..degree
        real(dp) :: mu = 0          !! m^3/s^2
        real(dp) :: radius = 0      !! Reference radius, m
        type(harmonic_function_t) :: harmonics              !! U
    contains
        procedure :: acceleration => geopotential_acceleration
        procedure :: potential => geopotential_potential
        procedure :: gradient_tensor => geopotential_gradient_tensor
        procedure :: all_derivatives => geopotential_all_derivatives    !! By one recursion
        procedure :: accelerations => geopotential_accelerations        !! Several places together
    end type geopotential_t

contains

    !> EGM96 (Lemoine et al. 1998, tide-free) with its own mu and radius. Fails when the degree is
    !> not in 0..70 or the order not in 0..degree.
    subroutine egm96(degree, order, model, error)
        integer, intent(in) :: degree   !! 0 to 70
        integer, intent(in) :: order    !! 0 to the degree
        type(geopotential_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: c(:, :), s(:, :)
        integer :: n, first

        call check_degree_and_order(degree, order, EGM96_DEGREE, error)
        if (allocated(error)) return
        allocate (c(0:degree, 0:degree), s(0:degree, 0:degree), source=0.0_dp)
        do n = 0, degree
            first = n*(n + 1)/2 + 1
            c(n, :n) = EGM96_C(first:first + n)
            s(n, :n) = EGM96_S(first:first + n)
        end do
        call new_geopotential('EGM96', EGM96_GM, EGM96_RADIUS, c, s, degree, order, model, error)
    end subroutine egm96

    !> A geopotential of given coefficients:
    !>
    !>     U = (mu/r) sum_nm (R/r)^n Pbar_nm(sin lat) [C_nm cos m lon + S_nm sin m lon]
    !>
    !> CSR-TM-00-01 eq. (2-2), in which mu/r stands before the sum and the term of degree 0 is the
    !> central one. Fails on a degree or order out of range and on numbers that are not finite.
    subroutine new_geopotential(name, mu, radius, c, s, degree, order, model, error)
        character(*), intent(in) :: name    !! For output
        real(dp), intent(in) :: mu          !! m^3/s^2
        real(dp), intent(in) :: radius      !! R, m
        real(dp), intent(in) :: c(0:, 0:)   !! Fully normalised; (n, m) at least to (degree, order)
        real(dp), intent(in) :: s(0:, 0:)
        !! Likewise; (n, 0) is not used
        integer, intent(in) :: degree       !! Up to which the sum goes
        integer, intent(in) :: order        !! Up to which the sum goes
        type(geopotential_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        integer :: available

        available = min(MAX_DEGREE, ubound(c, 1), ubound(s, 1))
        call check_degree_and_order(degree, order, available, error)
        if (allocated(error)) return
        if (min(ubound(c, 2), ubound(s, 2)) < order) then
            call fail(error, name//': there are no coefficients up to order '// &
                      integer_text(order))
            return
        end if
        if (.not. (mu > 0 .and. mu <= huge(mu) .and. radius > 0 .and. radius <= huge(radius))) then
            call fail(error, name//': the gravitational constant ('//number_text(mu)// &
                      ' m^3/s^2) and the radius ('//number_text(radius)//' m) must be positive')
            return
        end if
        model%harmonics = new_harmonic_function(radius, mu/radius, c(:degree, :order), s(:degree, :order))
        if (.not. model%harmonics%is_finite()) then
            call fail(error, name//': a coefficient is not a finite number')
            return
        end if
        model%name = name
        model%degree = degree
        model%order = order
        model%mu = mu
        model%radius = radius
    end subroutine new_geopotential

    !> Fails unless 0 <= degree <= highest and 0 <= order <= degree.
    subroutine check_degree_and_order(degree, order, highest, error)
        integer, intent(in) :: degree, order, highest   !! As asked for, and the model's own
        type(error_t), allocatable, intent(out) :: error

        if (degree < 0 .or. degree > highest) then
            call fail_out_of_range(error, 'degree', real(degree, dp), 0.0_dp, real(highest, dp))
        else if (order < 0 .or. order > degree) then
            call fail_out_of_range(error, 'order', real(order, dp), 0.0_dp, real(degree, dp))
        end if
    end subroutine check_degree_and_order

    !> The gradient of (2-2), for (2-3): Cartesian sums, so that the spherical axes of (2-5) are not needed.
    pure subroutine geopotential_acceleration(self, position, a)
        class(geopotential_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: a(3)

        call self%harmonics%gradient(position, a)
    end subroutine geopotential_acceleration

    pure subroutine geopotential_potential(self, position, u)
        class(geopotential_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: u

        call self%harmonics%value(position, u)
    end subroutine geopotential_potential

    pure subroutine geopotential_gradient_tensor(self, position, tensor)
        class(geopotential_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: tensor(3, 3)

        real(dp) :: u, a(3)

        call self%harmonics%derivatives(position, u, a, tensor)
    end subroutine geopotential_gradient_tensor

    !> Potential, acceleration and second derivatives by one recursion, in about twice the time of the acceleration. The
    !> bits are those of the procedures for one of them.
    pure subroutine geopotential_all_derivatives(self, position, u, a, tensor)
        class(geopotential_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: u, a(3), tensor(3, 3)

        call self%harmonics%derivatives(position, u, a, tensor)
    end subroutine geopotential_all_derivatives

    !> In half the time a place that one takes by itself where vectors are wide; the bits are those of `acceleration` and
    !> `potential`.
    pure subroutine geopotential_accelerations(self, positions, a, u)
        class(geopotential_t), intent(in) :: self
        real(dp), intent(in) :: positions(:, :)
        real(dp), intent(out) :: a(:, :)
        real(dp), intent(out), optional :: u(:)

        call self%harmonics%gradients(positions, a, u)
    end subroutine geopotential_accelerations

    !> Potential, acceleration and second derivatives of any model.
    pure subroutine derivatives_one_by_one(self, position, u, a, tensor)
        class(gravity_model_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! Earth-fixed, m
        real(dp), intent(out) :: u              !! Potential, m^2/s^2
        real(dp), intent(out) :: a(3)           !! Acceleration, Earth-fixed, m/s^2
        real(dp), intent(out) :: tensor(3, 3)   !! Second derivatives, Earth-fixed, 1/s^2

        call self%potential(position, u)
        call self%acceleration(position, a)
        call self%gradient_tensor(position, tensor)
    end subroutine derivatives_one_by_one

    !> Accelerations of any model at many places, and its potential if wanted.
    pure subroutine accelerations_one_by_one(self, positions, a, u)
        class(gravity_model_t), intent(in) :: self
        real(dp), intent(in) :: positions(:, :)     !! Earth-fixed, m, shape (3, n)
        real(dp), intent(out) :: a(:, :)            !! Earth-fixed, m/s^2, shape (3, n)
        real(dp), intent(out), optional :: u(:)     !! Potentials, m^2/s^2, n

        integer :: i

        do i = 1, size(positions, 2)
            call self%acceleration(positions(:, i), a(:, i))
            if (present(u)) call self%potential(positions(:, i), u(i))
        end do
    end subroutine accelerations_one_by_one

    pure subroutine point_mass_acceleration(self, position, a)
        class(point_mass_gravity_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: a(3)

        real(dp) :: r_squared

        r_squared = dot_product(position, position)
        a = -self%mu/(r_squared*sqrt(r_squared))*position
    end subroutine point_mass_acceleration

    pure subroutine point_mass_potential(self, position, u)
        class(point_mass_gravity_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: u

        u = self%mu/sqrt(dot_product(position, position))
    end subroutine point_mass_potential

    !> (mu/r^3) (3 u u^T - 1) with the unit vector u of the position.
    pure subroutine point_mass_gradient_tensor(self, position, tensor)
        class(point_mass_gravity_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! Earth-fixed, m
        real(dp), intent(out) :: tensor(3, 3)   !! Earth-fixed, 1/s^2

        real(dp) :: r_squared, factor
        integer :: i

        r_squared = dot_product(position, position)
        factor = self%mu/(r_squared*sqrt(r_squared))
        do i = 1, 3
            tensor(:, i) = 3*factor*position(i)/r_squared*position
            tensor(i, i) = tensor(i, i) - factor
        end do
    end subroutine point_mass_gradient_tensor
end module gracecg_environment_geopotential
