!> Density, temperature and composition of the thermosphere: what every model gives, and
!> `density_wave_t`, the short-period perturbation that the report includes but does not define.
!> The models by name: gracecg_environment_density_models.
module gracecg_environment_thermosphere
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    implicit none
    private
    public :: density_model_t, atmosphere_point_t, atmosphere_state_t
    public :: density_wave_t, REPORT_WAVE_AMPLITUDE, REPORT_WAVE_PERIOD
    public :: EARTH_RADIUS, SURFACE_GRAVITY, GAS_CONSTANT, ATOMIC_MASS_UNIT, MASS_O

    type :: atmosphere_point_t
        !! Where and when
        real(dp) :: height              !! Geodetic, m
        real(dp) :: latitude            !! Geodetic, rad
        real(dp) :: local_solar_time    !! h, cyclic
        real(dp) :: day_of_year         !! With fraction, 0.0 at 1 January 0 h UTC
    end type atmosphere_point_t

    type :: atmosphere_state_t
        !! The air at a point
        real(dp) :: density                     !! kg/m^3
        real(dp) :: temperature                 !! K
        real(dp) :: exospheric_temperature      !! K
        real(dp) :: n_he, n_o, n_n2, n_o2       !! Number densities of He, O, N2, O2, 1/m^3
        real(dp) :: n_h = 0                     !! Of H, where a model has it, 1/m^3
    end type atmosphere_state_t

    type, abstract :: density_model_t
        !! What gives the state of the air at a point
        real(dp) :: valid_from = -huge(1.0_dp)  !! m; no lower end unless a model has one
    contains
        procedure(evaluate_interface), deferred :: evaluate !! The air at a point
        procedure :: lowest_height                          !! Where the model's range begins
    end type density_model_t

    abstract interface
        !> The air at a point. Below `lowest_height` it is that at `lowest_height`: the caller
        !> checks.
        pure subroutine evaluate_interface(self, point, state)
            import :: density_model_t, atmosphere_point_t, atmosphere_state_t
            class(density_model_t), intent(in) :: self
            type(atmosphere_point_t), intent(in) :: point
            type(atmosphere_state_t), intent(out) :: state
        end subroutine evaluate_interface
    end interface

    real(dp), parameter :: REPORT_WAVE_AMPLITUDE = 0.0072_dp        !! Relative to the model's density
    real(dp), parameter :: REPORT_WAVE_PERIOD = 19.9_dp             !! s
    !! Fitted to Tables 6.1 and 6.2 and the axes of Figures 5.2, 5.3, 5.6 and 5.7 of CSR-TM-00-01 together, by
    !! likelihood: tools/wave_likelihood.py, docs/validation.md. The report does not say what its short-period
    !! perturbations are; 0.0064 and 15.5 s, 0.0092 and 31 s are as likely by the tables

    type :: density_wave_t
        !! A sinusoidal relative change of the density: an assumption, since CSR-TM-00-01 does not define its
        !! short-period perturbations
        real(dp) :: amplitude = 0.0_dp      !! Relative
        real(dp) :: period = REPORT_WAVE_PERIOD     !! s
        real(dp) :: phase = 0.0_dp          !! rad
    contains
        procedure :: relative_change    !! Of the density, at a time
    end type density_wave_t

    ! Constants of the program of DTM-77 (Barlier et al. 1978) that other models share
    real(dp), parameter :: EARTH_RADIUS = 6356.77e3_dp              !! m
    real(dp), parameter :: SURFACE_GRAVITY = 9.80665_dp             !! m/s^2
    real(dp), parameter :: GAS_CONSTANT = 8.314_dp                  !! J/(mol K)
    real(dp), parameter :: ATOMIC_MASS_UNIT = 1.6603e-27_dp         !! kg
    real(dp), parameter :: MASS_O = 16                              !! g/mol

contains

    !> The height in m from which on the model is valid.
    pure real(dp) function lowest_height(self)
        class(density_model_t), intent(in) :: self

        lowest_height = self%valid_from
    end function lowest_height

    !> The relative change of the density at a time: amplitude sin(2 pi t/period + phase).
    pure real(dp) function relative_change(self, elapsed_seconds)
        class(density_wave_t), intent(in) :: self
        real(dp), intent(in) :: elapsed_seconds     !! Since the epoch, s

        relative_change = 0
        if (abs(self%amplitude) > 0) &
            relative_change = self%amplitude*sin(TWO_PI*elapsed_seconds/self%period + self%phase)
    end function relative_change
end module gracecg_environment_thermosphere
