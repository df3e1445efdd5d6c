!> Gravity and magnetic field of the Earth at one place.
module gracecg_environment_gravity_and_field
    use gracecg_base_kinds, only: dp
    use gracecg_environment_spherical_harmonics, only: gradients_of_two
    use gracecg_environment_geopotential, only: gravity_model_t, geopotential_t
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t, igrf_t
    implicit none
    private
    public :: evaluate_gravity_and_field

contains

    !> What `acceleration` and `evaluate` of the two models give, to the last bit; spherical harmonics of both are summed
    !> together.
    pure subroutine evaluate_gravity_and_field(gravity, field, position, a, b)
        class(gravity_model_t), intent(in) :: gravity
        class(geomagnetic_model_t), intent(in) :: field
        real(dp), intent(in) :: position(3)     !! Earth-fixed, m
        real(dp), intent(out) :: a(3)           !! Acceleration, Earth-fixed, m/s^2
        real(dp), intent(out) :: b(3)           !! Magnetic flux density, Earth-fixed, T

        select type (gravity)
        type is (geopotential_t)
            select type (field)
            type is (igrf_t)
                call gradients_of_two(gravity%harmonics, field%potential, position, a, b)
                return
            end select
        end select
        call gravity%acceleration(position, a)
        call field%evaluate(position, b)
    end subroutine evaluate_gravity_and_field
end module gracecg_environment_gravity_and_field
