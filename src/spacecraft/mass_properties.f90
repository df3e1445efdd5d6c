!> Mass, inertia and the offset between centre of mass and proof mass. Body axes begin at the centre of mass,
!> CSR-TM-00-01 eq. (2-32).
module gracecg_spacecraft_mass_properties
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_vectors, only: identity, determinant_3x3
    implicit none
    private
    public :: mass_properties_t, validate_mass_properties
    public :: inertia_about_com, centre_of_gravity_offset

    real(dp), parameter :: SYMMETRY_TOLERANCE = 1e-9_dp
    !! Difference of two products of inertia that should be equal, relative to the largest element

    type :: mass_properties_t
        !! What is known of the satellite's mass distribution; body axes
        real(dp) :: mass = 0                    !! m_S, kg
        real(dp) :: inertia_pmc(3, 3) = 0
        !! J_p, inertia tensor about the proof mass centre, kg m^2; products of inertia with the
        !! sign of CSR-TM-00-01 eq. (2-17), J_p(1,2) = I_xy = -integral of x y dm
        real(dp) :: com_to_pmc(3) = 0
        !! d, from the centre of mass to the proof mass centre, m
    end type mass_properties_t

contains

    !> Inertia tensor (2-17) about the centre of mass by the Huygens-Steiner theorem, CSR-TM-00-01 eq.
    !> (2-18): J = J_p - m_S (d.d I - d d^T), kg m^2; also (4-2), (4-3).
    pure function inertia_about_com(self) result(inertia)
        type(mass_properties_t), intent(in) :: self
        real(dp) :: inertia(3, 3)

        integer :: i

        associate (d => self%com_to_pmc)
            do i = 1, 3
                inertia(:, i) = self%inertia_pmc(:, i) + self%mass*d(i)*d
                inertia(i, i) = inertia(i, i) - self%mass*dot_product(d, d)
            end do
        end associate
    end function inertia_about_com

    !> Position of the centre of gravity from the centre of mass, to first order in size over orbit
    !> radius: with the unit vector c from the Earth's centre,
    !>
    !>     3/(4 m_S R_c) [4 J c - (trace J + c.J c) c],
    !>
    !> which in principal axes is CSR-TM-00-01 eqs. (2-33), (2-34) (F. P. J. Rimrott, Introductory
    !> Attitude Dynamics, 1989). For the values of section 2.5 the z component is -9.68e-8 m: the
    !> sign printed in (2-35) is not that of alpha_3 = pi.
    pure function centre_of_gravity_offset(mass, inertia, radial, orbit_radius) result(offset)
        real(dp), intent(in) :: mass            !! m_S, kg
        real(dp), intent(in) :: inertia(3, 3)   !! J, about the centre of mass, kg m^2
        real(dp), intent(in) :: radial(3)       !! c, unit vector upwards, body axes
        real(dp), intent(in) :: orbit_radius    !! R_c, m
        real(dp) :: offset(3)                   !! Body axes, m

        real(dp) :: inertia_radial(3)

        inertia_radial = matmul(inertia, radial)
        offset = 3/(4*mass*orbit_radius)* &
                 (4*inertia_radial - (trace(inertia) + dot_product(radial, inertia_radial))*radial)
    end function centre_of_gravity_offset

    !> Fails when the properties cannot be those of a body: mass not positive, a number not
    !> finite, or an inertia tensor, about the proof mass centre or about the centre of mass, that
    !> is not symmetric, not positive definite, or has one principal moment greater than the sum
    !> of the others.
    subroutine validate_mass_properties(self, error)
        type(mass_properties_t), intent(in) :: self
        type(error_t), allocatable, intent(out) :: error

        if (.not. (self%mass > 0 .and. ieee_is_finite(self%mass))) then
            call fail(error, 'mass = '//number_text(self%mass)// &
                      ' kg: the mass has to be positive and finite')
        else if (.not. all(ieee_is_finite(self%com_to_pmc))) then
            call fail(error, 'com_to_pmc (from centre of mass to proof mass): not a finite number')
        else
            call validate_inertia(self%inertia_pmc, 'inertia about the proof mass centre', error)
            if (allocated(error)) return
            call validate_inertia(inertia_about_com(self), 'inertia about the centre of mass '// &
                                  '(shifted from the proof mass by com_to_pmc)', error)
        end if
    end subroutine validate_mass_properties

    subroutine validate_inertia(inertia, name, error)
        real(dp), intent(in) :: inertia(3, 3)       !! kg m^2
        character(*), intent(in) :: name            !! For the message
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: asymmetry

        if (.not. all(ieee_is_finite(inertia))) then
            call fail(error, name//': not a finite number')
            return
        end if
        asymmetry = maxval(abs(inertia - transpose(inertia)))
        if (asymmetry > SYMMETRY_TOLERANCE*maxval(abs(inertia))) then
            call fail(error, name//': the tensor is not symmetric; two elements that should be '// &
                      'equal differ by '//number_text(asymmetry)//' kg m^2')
        else if (.not. is_positive_definite(inertia)) then
            call fail(error, name//': the tensor is not positive definite; a moment of inertia '// &
                      'is zero or negative, or a product of inertia too large')
        else if (.not. is_positive_definite(trace(inertia)/2*identity(3) - inertia)) then
            call fail(error, name//': no body has this tensor; one principal moment of inertia '// &
                      'reaches the sum of the two others')
        end if
    end subroutine validate_inertia

    !> Sylvester's criterion: all leading minors are positive. Applied to trace(J)/2 I - J, the
    !> second moments of the mass distribution, it is the triangle inequality of the principal
    !> moments.
    pure logical function is_positive_definite(m)
        real(dp), intent(in) :: m(3, 3)     !! Symmetric

        is_positive_definite = m(1, 1) > 0 .and. m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1) > 0 .and. &
                               determinant_3x3(m) > 0
    end function is_positive_definite

    pure real(dp) function trace(m)
        real(dp), intent(in) :: m(3, 3)

        trace = m(1, 1) + m(2, 2) + m(3, 3)
    end function trace
end module gracecg_spacecraft_mass_properties
