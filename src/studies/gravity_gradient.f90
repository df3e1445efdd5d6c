!> The acceleration that the gravity gradient adds at the proof mass, CSR-TM-00-01 eq. (3-4) and Figure
!> 3.1: that of the central term mu/r of the geopotential, which (3-6) keeps, and that of all other terms,
!> which it leaves out.
module gracecg_studies_gravity_gradient
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM
    use gracecg_base_vectors, only: cross, unit
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_files_data_table, only: data_table_t
    use gracecg_environment_geopotential, only: gravity_model_t, geopotential_t, point_mass_gravity_t
    use gracecg_simulation_dynamics, only: POSITION, VELOCITY, ATTITUDE
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, ORBIT_INTERVAL
    implicit none
    private
    public :: gradient_sample_t, gradient_along_orbit, gradient_table

    !> At one place of the orbit, in the radial, transverse (in the plane of the orbit, forward) and normal
    !> direction.
    type :: gradient_sample_t
        real(dp) :: time = 0            !! From the epoch of the orbit, s
        real(dp) :: central(3) = 0      !! By the central term, m/s^2
        real(dp) :: others(3) = 0       !! By the sum of all other terms, m/s^2
    end type gradient_sample_t

contains

    !> -G d along the orbit, G the second derivatives of the geopotential, d the offset.
    function gradient_along_orbit(orbit, offset, step) result(samples)
        type(nominal_orbit_t), intent(in) :: orbit
        real(dp), intent(in) :: offset(3)       !! d, from centre of mass to proof mass, body axes, m
        integer, intent(in) :: step             !! From sample to sample of the orbit
        type(gradient_sample_t), allocatable :: samples(:)

        type(point_mass_gravity_t) :: central
        integer :: i

        central%mu = gm_of(orbit%dynamics%gravity)
        allocate (samples(0:int(orbit%revolution/(step*ORBIT_INTERVAL))))
        do i = 0, ubound(samples, 1)
            samples(i) = sample_at(orbit, central, offset, i*step)
        end do
    end function gradient_along_orbit

    pure function sample_at(orbit, central, offset, k) result(sample)
        type(nominal_orbit_t), intent(in) :: orbit
        type(point_mass_gravity_t), intent(in) :: central
        real(dp), intent(in) :: offset(3)
        integer, intent(in) :: k                !! Of the orbit's samples
        type(gradient_sample_t) :: sample

        real(dp) :: fixed_from_inertial(3, 3), rtn_from_inertial(3, 3), inertial_offset(3)
        real(dp) :: all_terms(3, 3), one_term(3, 3)

        associate (state => orbit%state(:, k))
            sample%time = k*ORBIT_INTERVAL
            fixed_from_inertial = orbit%dynamics%earth%from_inertial(sample%time)
            inertial_offset = matmul(offset, rotation_matrix(state(ATTITUDE)))
            call orbit%dynamics%gravity%gradient_tensor(matmul(fixed_from_inertial, state(POSITION)), all_terms)
            call central%gradient_tensor(matmul(fixed_from_inertial, state(POSITION)), one_term)
            rtn_from_inertial(1, :) = unit(state(POSITION))
            rtn_from_inertial(3, :) = unit(cross(state(POSITION), state(VELOCITY)))
            rtn_from_inertial(2, :) = cross(rtn_from_inertial(3, :), rtn_from_inertial(1, :))
        end associate
        sample%central = -rotated(one_term)
        sample%others = -rotated(all_terms - one_term)

    contains

        !> An Earth-fixed tensor times the offset.
        pure function rotated(tensor) result(vector)
            real(dp), intent(in) :: tensor(3, 3)
            real(dp) :: vector(3)

            vector = matmul(tensor, matmul(fixed_from_inertial, inertial_offset))
            vector = matmul(rtn_from_inertial, matmul(vector, fixed_from_inertial))
        end function rotated
    end function sample_at

    !> mu of a model, m^3/s^2.
    pure real(dp) function gm_of(model)
        class(gravity_model_t), intent(in) :: model

        gm_of = EARTH_GM
        select type (model)
        type is (geopotential_t)
            gm_of = model%mu
        type is (point_mass_gravity_t)
            gm_of = model%mu
        end select
    end function gm_of

    !> Figure 3.1: the gravity gradient along an orbit; radial, transverse, normal.
    function gradient_table(samples) result(table)
        type(gradient_sample_t), intent(in) :: samples(:)
        type(data_table_t) :: table

        integer :: i

        call table%columns_of('time_s,central_r_m_s2,central_t_m_s2,central_n_m_s2,others_r_m_s2,others_t_m_s2,others_n_m_s2')
        do i = 1, size(samples)
            call table%add([samples(i)%time, samples(i)%central, samples(i)%others])
        end do
    end function gradient_table
end module gracecg_studies_gravity_gradient
