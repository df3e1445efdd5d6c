!> An exponential atmosphere, for checks and simple studies.
module gracecg_environment_exponential_density
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, require_range
    use gracecg_environment_thermosphere, only: density_model_t, atmosphere_point_t, atmosphere_state_t, &
        EARTH_RADIUS, SURFACE_GRAVITY, GAS_CONSTANT, ATOMIC_MASS_UNIT, MASS_O
    implicit none
    private
    public :: exponential_density_t, new_exponential_density

    type, extends(density_model_t) :: exponential_density_t
        !! rho = rho_0 exp(-(h - h_0)/H); made by `new_exponential_density`
        private
        real(dp) :: reference_density = 0.0_dp      !! kg/m^3
        real(dp) :: reference_height = 0.0_dp       !! m
        real(dp) :: scale_height = 1.0_dp           !! m
        real(dp) :: temperature = 0.0_dp            !! K
    contains
        procedure :: evaluate => evaluate_exponential
    end type exponential_density_t

contains

    !> An exponential atmosphere. So that surface models get a temperature and a composition, the
    !> gas is taken as atomic oxygen (an assumption) at the temperature that the scale height then
    !> means, T = H M g/R with g of the reference height.
    subroutine new_exponential_density(reference_density, reference_height, scale_height, model, &
                                       error)
        real(dp), intent(in) :: reference_density   !! kg/m^3
        real(dp), intent(in) :: reference_height    !! m
        real(dp), intent(in) :: scale_height        !! m
        type(exponential_density_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: gravity

        call require_range('reference density', reference_density, [1e-20_dp, 10.0_dp], 'kg/m^3', &
                           error)
        call require_range('reference height', reference_height, [0.0_dp, 1e7_dp], 'm', error)
        call require_range('scale height', scale_height, [1e3_dp, 1e6_dp], 'm', error)
        if (allocated(error)) return
        gravity = SURFACE_GRAVITY*(EARTH_RADIUS/(EARTH_RADIUS + reference_height))**2
        model%reference_density = reference_density
        model%reference_height = reference_height
        model%scale_height = scale_height
        model%temperature = scale_height*(1e-3_dp*MASS_O)*gravity/GAS_CONSTANT
    end subroutine new_exponential_density

    pure subroutine evaluate_exponential(self, point, state)
        class(exponential_density_t), intent(in) :: self
        type(atmosphere_point_t), intent(in) :: point
        type(atmosphere_state_t), intent(out) :: state

        state%density = self%reference_density* &
                        exp(-(point%height - self%reference_height)/self%scale_height)
        state%temperature = self%temperature
        state%exospheric_temperature = self%temperature
        state%n_he = 0
        state%n_o = state%density/(ATOMIC_MASS_UNIT*MASS_O)
        state%n_n2 = 0
        state%n_o2 = 0
    end subroutine evaluate_exponential
end module gracecg_environment_exponential_density
