!> The Drag Temperature Model of Barlier et al. (1978), DTM-77, which CSR-TM-00-01 section 2.3.2.1
!> takes.
module gracecg_environment_dtm77
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail, number_text, require_range
    use gracecg_environment_thermosphere, only: density_model_t, atmosphere_point_t, atmosphere_state_t, &
        EARTH_RADIUS, SURFACE_GRAVITY, GAS_CONSTANT, ATOMIC_MASS_UNIT, MASS_O
    use gracecg_environment_table_dtm77, only: DTM77_TEMPERATURE, DTM77_HELIUM, DTM77_OXYGEN, DTM77_NITROGEN
    implicit none
    private
    public :: dtm77_t, new_dtm77

    !> The expansion G(L) of Barlier et al. (1978) for the exospheric temperature or a constituent,
    !> with all that does not depend on the point worked out.
    type :: expansion_t
        real(dp) :: a(36)               !! Coefficients A(1..36)
        real(dp) :: beta                !! Factor of the annual and daily terms
        real(dp) :: constant            !! 1 + F1 + A7 Kp
        real(dp) :: factor_p20          !! A2 + A8 Kp
        ! Phases of the annual and semiannual terms as [cosine, sine]
        real(dp) :: annual(2), semiannual(2)
        real(dp) :: antisymmetric_annual(2), antisymmetric_semiannual(2)
    end type expansion_t

    !> Functions of place and time that the four expansions share: Legendre functions of the sine of
    !> the latitude (not normalised, without the factor (-1)^m), cosines and sines.
    type :: harmonics_t
        real(dp) :: p10, p20, p30, p40, p50, p11, p21, p31, p51, p22, p32, p33
        ! [cosine, sine] of the day in the year, of twice it, and of one to three times the hour
        real(dp) :: year(2), half_year(2), day(2), half_day(2), third_day(2)
    end type harmonics_t

    type, extends(density_model_t) :: dtm77_t
        !! The Drag Temperature Model, DTM-77 (also called DTM-78), for given solar and geomagnetic
        !! activity; made by `new_dtm77`
        private
        type(expansion_t) :: temperature, helium, oxygen, nitrogen
    contains
        procedure :: evaluate => evaluate_dtm77
    end type dtm77_t

    ! Constants of the model DTM-77 (Barlier et al. 1978, and the program listed there)
    real(dp), parameter :: BASE_HEIGHT = 120e3_dp                   !! m
    real(dp), parameter :: BASE_RADIUS = EARTH_RADIUS + BASE_HEIGHT
    real(dp), parameter :: BASE_TEMPERATURE = 380.0_dp              !! K
    real(dp), parameter :: SIGMA = 0.02e-3_dp + 1/BASE_RADIUS       !! 1/m
    real(dp), parameter :: BASE_GRAVITY = SURFACE_GRAVITY*(EARTH_RADIUS/BASE_RADIUS)**2
    real(dp), parameter :: MASS_HE = 4, MASS_N2 = 28, MASS_O2 = 32     ! g/mol
    real(dp), parameter :: THERMAL_DIFFUSION_HE = -0.38_dp          !! 0 for O, N2, O2
    real(dp), parameter :: BASE_DENSITY_O2 = 4.775e10_dp            !! 1/cm^3, constant at 120 km
    real(dp), parameter :: PER_CUBIC_METRE = 1e6_dp                 !! 1/m^3 in 1/cm^3
    real(dp), parameter :: YEAR = 365.0_dp                          !! days, of the annual terms
    real(dp), parameter :: MEAN_FLUX = 150.0_dp                !! sfu, reference of the mean flux

contains

    !> DTM-77 of F. Barlier, C. Berger, J. L. Falin, G. Kockarts, G. Thuillier, Ann. Geophys. 34
    !> (1978) 9-24, with its printed coefficients. Fails for indices outside their range and for a
    !> pair of fluxes that do not belong together.
    subroutine new_dtm77(f107, f107_mean, kp, model, error)
        real(dp), intent(in) :: f107        !! F10.7 of the day before, as observed, sfu
        real(dp), intent(in) :: f107_mean   !! Its mean over 81 days, sfu
        real(dp), intent(in) :: kp          !! Kp three hours before, 0 to 9
        type(dtm77_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: FLUXES(2) = [50.0_dp, 500.0_dp]          ! sfu
        real(dp), parameter :: LOWEST_MEAN_TEMPERATURE = 500.0_dp       ! K
        real(dp) :: mean_temperature

        call require_range('f107', f107, FLUXES, 'sfu', error)
        call require_range('f107_mean', f107_mean, FLUXES, 'sfu', error)
        call require_range('kp', kp, [0.0_dp, 9.0_dp], '', error)
        if (allocated(error)) return
        model%valid_from = BASE_HEIGHT
        model%temperature = new_expansion(DTM77_TEMPERATURE, f107, f107_mean, kp)
        model%helium = new_expansion(DTM77_HELIUM, f107, f107_mean, kp)
        model%oxygen = new_expansion(DTM77_OXYGEN, f107, f107_mean, kp)
        model%nitrogen = new_expansion(DTM77_NITROGEN, f107, f107_mean, kp)
        model%helium%beta = 1
        mean_temperature = model%temperature%a(1)*model%temperature%constant
        if (mean_temperature < LOWEST_MEAN_TEMPERATURE) then
            call fail(error, 'f107 = '//number_text(f107)//' and f107_mean = '// &
                      number_text(f107_mean)//' sfu are too far apart for DTM-77: they give a '// &
                      'mean exospheric temperature of '//number_text(mean_temperature)// &
                      ' K; a day''s flux lies within some 100 sfu of its 81-day mean')
        end if
    end subroutine new_dtm77

    !> The part of an expansion that does not depend on the point: F1, M and the annual phases.
    pure function new_expansion(a, f107, f107_mean, kp) result(e)
        real(dp), intent(in) :: a(36)
        real(dp), intent(in) :: f107, f107_mean, kp
        type(expansion_t) :: e

        real(dp) :: f1

        f1 = a(4)*(f107 - f107_mean) + a(5)*(f107 - f107_mean)**2 + a(6)*(f107_mean - MEAN_FLUX)
        e%a = a
        e%beta = 1 + f1
        e%constant = 1 + f1 + a(7)*kp
        e%factor_p20 = a(2) + a(8)*kp
        e%annual = cosine_sine(TWO_PI*a(11)/YEAR)
        e%semiannual = cosine_sine(2*TWO_PI*a(14)/YEAR)
        e%antisymmetric_annual = cosine_sine(TWO_PI*a(18)/YEAR)
        e%antisymmetric_semiannual = cosine_sine(2*TWO_PI*a(20)/YEAR)
    end function new_expansion

    !> Temperature by the profile of Bates, constituents in diffusive equilibrium above 120 km:
    !> Barlier et al. (1978). He carries thermal diffusion.
    pure subroutine evaluate_dtm77(self, point, state)
        class(dtm77_t), intent(in) :: self
        type(atmosphere_point_t), intent(in) :: point
        type(atmosphere_state_t), intent(out) :: state

        type(harmonics_t) :: h
        real(dp) :: height, geopotential_height, log_temperature_ratio, t_inf

        h = harmonics_of(point)
        height = point%height
        if (height < BASE_HEIGHT) height = BASE_HEIGHT      ! and not max(), which may drop a NaN
        geopotential_height = (height - BASE_HEIGHT)*BASE_RADIUS/(EARTH_RADIUS + height)

        t_inf = self%temperature%a(1)*expansion(self%temperature, h)
        state%exospheric_temperature = t_inf
        state%temperature = t_inf - (t_inf - BASE_TEMPERATURE)*exp(-SIGMA*geopotential_height)
        log_temperature_ratio = log(BASE_TEMPERATURE/state%temperature)

        state%n_he = number_density(self%helium%a(1), expansion(self%helium, h), &
                                    MASS_HE, THERMAL_DIFFUSION_HE)
        state%n_o = number_density(self%oxygen%a(1), expansion(self%oxygen, h), MASS_O, 0.0_dp)
        state%n_n2 = number_density(self%nitrogen%a(1), expansion(self%nitrogen, h), &
                                    MASS_N2, 0.0_dp)
        state%n_o2 = number_density(BASE_DENSITY_O2, 1.0_dp, MASS_O2, 0.0_dp)
        state%density = ATOMIC_MASS_UNIT*(MASS_HE*state%n_he + MASS_O*state%n_o + &
                                          MASS_N2*state%n_n2 + MASS_O2*state%n_o2)

    contains

        !> n = A(1) exp(G - 1) (T120/T)^(1 + alpha + gamma) exp(-sigma gamma xi) in 1/m^3: the two
        !> powers and the exponential in one.
        pure real(dp) function number_density(a1, g, molar_mass, thermal_diffusion) result(n)
            real(dp), intent(in) :: a1                  !! 1/cm^3
            real(dp), intent(in) :: g                   !! G(L)
            real(dp), intent(in) :: molar_mass          !! g/mol
            real(dp), intent(in) :: thermal_diffusion   !! alpha

            real(dp), parameter :: GAMMA_FACTOR = 1e-3_dp*BASE_GRAVITY/(SIGMA*GAS_CONSTANT)
            real(dp) :: gamma

            gamma = molar_mass*GAMMA_FACTOR/t_inf
            n = a1*PER_CUBIC_METRE*exp(g - 1 - SIGMA*gamma*geopotential_height + &
                                       (1 + thermal_diffusion + gamma)*log_temperature_ratio)
        end function number_density
    end subroutine evaluate_dtm77

    !> G(L) = 1 + F1 + M + Q + beta (AN1 + SAN1 + AN2 + SAN2 + D + SD + TD), Barlier et al. (1978).
    pure real(dp) function expansion(e, h) result(g)
        type(expansion_t), intent(in) :: e
        type(harmonics_t), intent(in) :: h

        real(dp) :: steady, annual, semiannual, season, antisymmetric
        real(dp) :: diurnal, semidiurnal, terdiurnal

        associate (a => e%a)
            steady = e%constant + e%factor_p20*h%p20 + a(3)*h%p40
            annual = (a(9) + a(10)*h%p20)*dot_product(e%annual, h%year)
            semiannual = (a(12) + a(13)*h%p20)*dot_product(e%semiannual, h%half_year)
            season = dot_product(e%antisymmetric_annual, h%year)
            antisymmetric = (a(15)*h%p10 + a(16)*h%p30 + a(17)*h%p50)*season + &
                            a(19)*h%p10*dot_product(e%antisymmetric_semiannual, h%half_year)
            diurnal = (a(21)*h%p11 + a(22)*h%p31 + a(23)*h%p51 + &
                       (a(24)*h%p11 + a(25)*h%p21)*season)*h%day(1) + &
                      (a(26)*h%p11 + a(27)*h%p31 + a(28)*h%p51 + &
                       (a(29)*h%p11 + a(30)*h%p21)*season)*h%day(2)
            semidiurnal = (a(31)*h%p22 + a(32)*h%p32*season)*h%half_day(1) + &
                          (a(33)*h%p22 + a(34)*h%p32*season)*h%half_day(2)
            terdiurnal = h%p33*(a(35)*h%third_day(1) + a(36)*h%third_day(2))
        end associate
        g = steady + e%beta*(annual + semiannual + antisymmetric + &
                             diurnal + semidiurnal + terdiurnal)
    end function expansion

    pure function harmonics_of(point) result(h)
        type(atmosphere_point_t), intent(in) :: point
        type(harmonics_t) :: h

        real(dp) :: x, c, x2, x4

        x = sin(point%latitude)
        c = cos(point%latitude)
        x2 = x**2
        x4 = x2**2
        h%p10 = x
        h%p20 = 1.5_dp*x2 - 0.5_dp
        h%p30 = x*(2.5_dp*x2 - 1.5_dp)
        h%p40 = (35*x4 - 30*x2 + 3)/8
        h%p50 = x*(63*x4 - 70*x2 + 15)/8
        h%p11 = c
        h%p21 = 3*x*c
        h%p31 = 1.5_dp*c*(5*x2 - 1)
        h%p51 = 1.875_dp*c*(21*x4 - 14*x2 + 1)
        h%p22 = 3*c**2
        h%p32 = 15*x*c**2
        h%p33 = 15*c**3
        h%year = cosine_sine(TWO_PI*point%day_of_year/YEAR)
        h%half_year = sum_of_angles(h%year, h%year)
        h%day = cosine_sine(TWO_PI*point%local_solar_time/24)
        h%half_day = sum_of_angles(h%day, h%day)
        h%third_day = sum_of_angles(h%half_day, h%day)
    end function harmonics_of

    pure function cosine_sine(angle) result(u)
        real(dp), intent(in) :: angle   !! rad
        real(dp) :: u(2)

        u = [cos(angle), sin(angle)]
    end function cosine_sine

    !> [cosine, sine] of the sum of two angles given likewise.
    pure function sum_of_angles(u, v) result(w)
        real(dp), intent(in) :: u(2), v(2)
        real(dp) :: w(2)

        w = [u(1)*v(1) - u(2)*v(2), u(2)*v(1) + u(1)*v(2)]
    end function sum_of_angles
end module gracecg_environment_dtm77
