!> External torques on the satellite that do not act through its surface, in body axes.
module gracecg_spacecraft_gravity_gradient_torque
    use gracecg_base_kinds, only: dp
    use gracecg_base_vectors, only: cross, transformed
    implicit none
    private
    public :: gravity_gradient_torque

contains

    !> Torque of a spherical Earth's gravity gradient, CSR-TM-00-01 eq. (2-23) (P. C. Hughes,
    !> Spacecraft Attitude Dynamics, 1986), in vector form T = 3 mu/R_c^3 c x (J c). The third term of
    !> the printed first row is corrected: I_zx c1 c2. It is what (2-22) becomes for a small satellite.
    pure function gravity_gradient_torque(mu, radius, vertical, inertia) result(torque)
        real(dp), intent(in) :: mu              !! m^3/s^2
        real(dp), intent(in) :: radius          !! R_c, distance from the Earth's centre, m
        real(dp), intent(in) :: vertical(3)     !! c, unit vector away from the Earth's centre
        real(dp), intent(in) :: inertia(3, 3)   !! J, about the centre of mass, kg m^2
        real(dp) :: torque(3)                   !! N m

        torque = 3*mu/radius**3*cross(vertical, transformed(inertia, vertical))
    end function gravity_gradient_torque
end module gracecg_spacecraft_gravity_gradient_torque
