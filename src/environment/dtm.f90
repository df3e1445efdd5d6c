!> The Drag Temperature Models: DTM-77 of Barlier et al. (1978), which CSR-TM-00-01 section 2.3.2.1 takes,
!> DTM-78 as CNES has it, and DTM-94 of Berger et al. (1998).
module gracecg_environment_dtm
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI, PI
    use gracecg_base_error, only: error_t, fail, fail_unknown_name, number_text, require_range
    use gracecg_base_lanes, only: LANES, WIDEST, lanes_sines_cosines
    use gracecg_environment_thermosphere, only: density_model_t, atmosphere_point_t, atmosphere_state_t, &
        EARTH_RADIUS, SURFACE_GRAVITY, GAS_CONSTANT, ATOMIC_MASS_UNIT, MASS_O
    use gracecg_environment_table_dtm77, only: DTM77_TEMPERATURE, DTM77_HELIUM, DTM77_OXYGEN, DTM77_NITROGEN
    use gracecg_environment_table_dtm78, only: DTM78_TEMPERATURE, DTM78_HYDROGEN, DTM78_HELIUM, DTM78_OXYGEN, &
        DTM78_NITROGEN
    use gracecg_environment_table_dtm94, only: DTM94_TEMPERATURE, DTM94_HYDROGEN, DTM94_HELIUM, DTM94_OXYGEN, &
        DTM94_NITROGEN
    implicit none
    private
    public :: dtm_t, new_dtm, DTM_EDITIONS

    !> The editions of the model, by the year
    character(5), parameter :: DTM_EDITIONS(3) = ['dtm77', 'dtm78', 'dtm94']

    integer, parameter :: TERMS = 39    !! Coefficients of DTM-94; the earlier ones end at 36

    !> The expansion G(L) for the exospheric temperature or a constituent, with all that does not depend on
    !> the point worked out.
    type :: expansion_t
        real(dp) :: a(TERMS) = 0        !! Coefficients A(1..39)
        real(dp) :: beta                !! Factor of the annual and daily terms
        real(dp) :: flux                !! 1 + F1
        logical :: exponential_kp = .false.     !! A(39) stands by exp(Kp), not by Kp^2
        ! Phases of the annual and semiannual terms as [cosine, sine]
        real(dp) :: annual(2), semiannual(2)
        real(dp) :: antisymmetric_annual(2), antisymmetric_semiannual(2)
    end type expansion_t

    !> Functions of place and time that the expansions share: Legendre functions of the sine of
    !> the latitude (not normalised, without the factor (-1)^m), cosines and sines.
    type :: harmonics_t
        real(dp) :: p10, p20, p30, p40, p50, p11, p21, p31, p51, p22, p32, p33
        ! [cosine, sine] of the day in the year, of twice it, and of one to three times the hour
        real(dp) :: year(2), half_year(2), day(2), half_day(2), third_day(2)
        real(dp) :: kp      !! Of the place: see dtm_t
    end type harmonics_t

    type, extends(density_model_t) :: dtm_t
        !! A Drag Temperature Model for given solar and geomagnetic activity; made by `new_dtm`
        private
        type(expansion_t) :: temperature, hydrogen, helium, oxygen, nitrogen
        real(dp) :: kp_pole, kp_equator     !! Kp three hours before; DTM-94: at the pole, six at the equator
        real(dp) :: gas_constant = GAS_CONSTANT         !! J/(mol K)
        real(dp) :: thermal_diffusion_h = 0             !! alpha of hydrogen
        logical :: with_gradient = .false.
        !! The temperature's gradient at 120 km is given (DTM-94), and not sigma
    contains
        procedure :: evaluate => evaluate_dtm
    end type dtm_t

    ! Constants of the model DTM-77 (Barlier et al. 1978, and the program listed there); those of the later
    ! editions where they differ
    real(dp), parameter :: BASE_HEIGHT = 120e3_dp                   !! m
    real(dp), parameter :: BASE_RADIUS = EARTH_RADIUS + BASE_HEIGHT
    real(dp), parameter :: BASE_TEMPERATURE = 380.0_dp              !! K
    real(dp), parameter :: SIGMA = 0.02e-3_dp + 1/BASE_RADIUS       !! 1/m
    real(dp), parameter :: BASE_GRADIENT_94 = 14.348e-3_dp          !! K/m, DTM-94
    real(dp), parameter :: BASE_GRAVITY = SURFACE_GRAVITY*(EARTH_RADIUS/BASE_RADIUS)**2
    real(dp), parameter :: GAS_CONSTANT_78 = 8.3143_dp              !! J/(mol K), CNES's DTM-78
    real(dp), parameter :: MASS_H = 1, MASS_HE = 4, MASS_N2 = 28, MASS_O2 = 32     ! g/mol
    real(dp), parameter :: THERMAL_DIFFUSION_HE = -0.38_dp          !! 0 for O, N2, O2
    real(dp), parameter :: THERMAL_DIFFUSION_H_78 = -0.40_dp, THERMAL_DIFFUSION_H_94 = -0.38_dp
    real(dp), parameter :: BASE_DENSITY_O2 = 4.775e10_dp            !! 1/cm^3, constant at 120 km
    real(dp), parameter :: PER_CUBIC_METRE = 1e6_dp                 !! 1/m^3 in 1/cm^3
    real(dp), parameter :: YEAR = 365.0_dp                          !! days, of the annual terms
    real(dp), parameter :: MEAN_FLUX = 150.0_dp                !! sfu, reference of the mean flux

contains

    !> The edition of a name:
    !>
    !> - dtm77: F. Barlier, C. Berger, J. L. Falin, G. Kockarts, G. Thuillier, Ann. Geophys. 34 (1978) 9-24,
    !>   with its printed coefficients;
    !> - dtm78: the same with seven figures changed and with hydrogen, as CNES has it;
    !> - dtm94: C. Berger, R. Biancale, M. Ill, F. Barlier, J. Geodesy 72 (1998) 161-178.
    !>
    !> Fails for a name that is not known, for indices outside their range and for a pair of fluxes that do not
    !> belong together.
    subroutine new_dtm(edition, f107, f107_mean, kp, model, error, kp_6h_before)
        character(*), intent(in) :: edition !! One of DTM_EDITIONS
        real(dp), intent(in) :: f107        !! F10.7 of the day before, as observed, sfu
        real(dp), intent(in) :: f107_mean   !! Its mean over 81 days, sfu
        real(dp), intent(in) :: kp          !! Kp three hours before, 0 to 9
        type(dtm_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: kp_6h_before
        !! For DTM-94, which takes it at the equator; by default as three hours before

        real(dp), parameter :: FLUXES(2) = [50.0_dp, 500.0_dp]          ! sfu
        real(dp), parameter :: LOWEST_MEAN_TEMPERATURE = 500.0_dp       ! K
        real(dp) :: mean_temperature

        call require_range('f107', f107, FLUXES, 'sfu', error)
        call require_range('f107_mean', f107_mean, FLUXES, 'sfu', error)
        call require_range('kp', kp, [0.0_dp, 9.0_dp], '', error)
        if (allocated(error)) return
        model%valid_from = BASE_HEIGHT
        model%kp_pole = kp
        model%kp_equator = kp
        select case (edition)
        case ('dtm77')
            model%temperature = new_expansion(DTM77_TEMPERATURE, f107, f107_mean)
            model%helium = new_expansion(DTM77_HELIUM, f107, f107_mean)
            model%oxygen = new_expansion(DTM77_OXYGEN, f107, f107_mean)
            model%nitrogen = new_expansion(DTM77_NITROGEN, f107, f107_mean)
        case ('dtm78')
            model%temperature = new_expansion(DTM78_TEMPERATURE, f107, f107_mean)
            model%hydrogen = new_expansion(DTM78_HYDROGEN, f107, f107_mean)
            model%helium = new_expansion(DTM78_HELIUM, f107, f107_mean)
            model%oxygen = new_expansion(DTM78_OXYGEN, f107, f107_mean)
            model%nitrogen = new_expansion(DTM78_NITROGEN, f107, f107_mean)
            model%gas_constant = GAS_CONSTANT_78
            model%thermal_diffusion_h = THERMAL_DIFFUSION_H_78
        case ('dtm94')
            model%temperature = new_expansion(DTM94_TEMPERATURE, f107, f107_mean)
            model%hydrogen = new_expansion(DTM94_HYDROGEN, f107, f107_mean)
            model%helium = new_expansion(DTM94_HELIUM, f107, f107_mean)
            model%oxygen = new_expansion(DTM94_OXYGEN, f107, f107_mean)
            model%nitrogen = new_expansion(DTM94_NITROGEN, f107, f107_mean)
            model%temperature%exponential_kp = .true.
            model%thermal_diffusion_h = THERMAL_DIFFUSION_H_94
            model%with_gradient = .true.
            if (present(kp_6h_before)) then
                call require_range('kp', kp_6h_before, [0.0_dp, 9.0_dp], '', error)
                if (allocated(error)) return
                model%kp_equator = kp_6h_before
            end if
        case default
            call fail_unknown_name(error, 'edition of the Drag Temperature Model', edition, DTM_EDITIONS)
            return
        end select
        model%hydrogen%beta = 1
        model%helium%beta = 1
        mean_temperature = model%temperature%a(1)*(model%temperature%flux + model%temperature%a(7)*kp)
        if (mean_temperature < LOWEST_MEAN_TEMPERATURE) then
            call fail(error, 'f107 = '//number_text(f107)//' and f107_mean = '// &
                      number_text(f107_mean)//' sfu are too far apart for '//edition//': they give a '// &
                      'mean exospheric temperature of '//number_text(mean_temperature)// &
                      ' K; a day''s flux lies within some 100 sfu of its 81-day mean')
        end if
    end subroutine new_dtm

    !> The part of an expansion that does not depend on the point: F1 and the annual phases.
    pure function new_expansion(a, f107, f107_mean) result(e)
        real(dp), intent(in) :: a(:)            !! As many as the edition has
        real(dp), intent(in) :: f107, f107_mean
        type(expansion_t) :: e

        real(dp) :: f1

        e%a(:size(a)) = a
        f1 = a(4)*(f107 - f107_mean) + a(5)*(f107 - f107_mean)**2 + a(6)*(f107_mean - MEAN_FLUX) + &
             e%a(38)*(f107_mean - MEAN_FLUX)**2
        e%beta = 1 + f1
        e%flux = 1 + f1
        e%annual = cosine_sine(TWO_PI*a(11)/YEAR)
        e%semiannual = cosine_sine(2*TWO_PI*a(14)/YEAR)
        e%antisymmetric_annual = cosine_sine(TWO_PI*a(18)/YEAR)
        e%antisymmetric_semiannual = cosine_sine(2*TWO_PI*a(20)/YEAR)
    end function new_expansion

    !> Temperature by the profile of Bates, constituents in diffusive equilibrium above 120 km:
    !> Barlier et al. (1978). Hydrogen and helium carry thermal diffusion. DTM-94 has the temperature's gradient
    !> at 120 km in place of sigma; its Kp is that of three hours before at the poles and six at the equator,
    !> between them by the latitude.
    pure subroutine evaluate_dtm(self, point, state)
        class(dtm_t), intent(in) :: self
        type(atmosphere_point_t), intent(in) :: point
        type(atmosphere_state_t), intent(out) :: state

        type(harmonics_t) :: h
        real(dp) :: height, geopotential_height, log_temperature_ratio, t_inf, rate, gamma_factor

        h = harmonics_of(point)
        h%kp = self%kp_pole + (self%kp_equator - self%kp_pole)*(1 - abs(point%latitude)/(PI/2))
        height = point%height
        if (height < BASE_HEIGHT) height = BASE_HEIGHT      ! and not max(), which may drop a NaN
        geopotential_height = (height - BASE_HEIGHT)*BASE_RADIUS/(EARTH_RADIUS + height)

        t_inf = self%temperature%a(1)*expansion(self%temperature, h)
        rate = SIGMA
        if (self%with_gradient) rate = BASE_GRADIENT_94/(t_inf - BASE_TEMPERATURE)
        gamma_factor = 1e-3_dp*BASE_GRAVITY/(rate*self%gas_constant)
        state%exospheric_temperature = t_inf
        state%temperature = t_inf - (t_inf - BASE_TEMPERATURE)*exp(-rate*geopotential_height)
        log_temperature_ratio = log(BASE_TEMPERATURE/state%temperature)

        if (self%hydrogen%a(1) > 0) then
            state%n_h = number_density(self%hydrogen%a(1), expansion(self%hydrogen, h), MASS_H, &
                                       self%thermal_diffusion_h)
        end if
        state%n_he = number_density(self%helium%a(1), expansion(self%helium, h), &
                                    MASS_HE, THERMAL_DIFFUSION_HE)
        state%n_o = number_density(self%oxygen%a(1), expansion(self%oxygen, h), MASS_O, 0.0_dp)
        state%n_n2 = number_density(self%nitrogen%a(1), expansion(self%nitrogen, h), &
                                    MASS_N2, 0.0_dp)
        state%n_o2 = number_density(BASE_DENSITY_O2, 1.0_dp, MASS_O2, 0.0_dp)
        state%density = ATOMIC_MASS_UNIT*(MASS_HE*state%n_he + MASS_O*state%n_o + &
                                          MASS_N2*state%n_n2 + MASS_O2*state%n_o2 + MASS_H*state%n_h)

    contains

        !> n = A(1) exp(G - 1) (T120/T)^(1 + alpha + gamma) exp(-sigma gamma xi) in 1/m^3: the two
        !> powers and the exponential in one.
        pure real(dp) function number_density(a1, g, molar_mass, thermal_diffusion) result(n)
            real(dp), intent(in) :: a1                  !! 1/cm^3
            real(dp), intent(in) :: g                   !! G(L)
            real(dp), intent(in) :: molar_mass          !! g/mol
            real(dp), intent(in) :: thermal_diffusion   !! alpha

            real(dp) :: gamma

            gamma = molar_mass*gamma_factor/t_inf
            n = a1*PER_CUBIC_METRE*exp(g - 1 - rate*gamma*geopotential_height + &
                                       (1 + thermal_diffusion + gamma)*log_temperature_ratio)
        end function number_density
    end subroutine evaluate_dtm

    !> G(L) = 1 + F1 + M + Q + beta (AN1 + SAN1 + AN2 + SAN2 + D + SD + TD), Barlier et al. (1978); A(37) P10 in Q
    !> and A(39) exp(Kp) or A(39) Kp^2 in M are of DTM-94.
    pure real(dp) function expansion(e, h) result(g)
        type(expansion_t), intent(in) :: e
        type(harmonics_t), intent(in) :: h

        real(dp) :: steady, annual, semiannual, season, antisymmetric
        real(dp) :: diurnal, semidiurnal, terdiurnal

        associate (a => e%a)
            steady = e%flux + a(7)*h%kp + (a(2) + a(8)*h%kp)*h%p20 + a(3)*h%p40 + a(37)*h%p10 + &
                     a(39)*merge(exp(h%kp), h%kp**2, e%exponential_kp)
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

        real(dp), dimension(LANES) :: turns, sine, cosine
        real(dp) :: x, c, x2, x4

        turns = 0
        turns(:3) = [point%latitude/TWO_PI, point%day_of_year/YEAR, point%local_solar_time/24]
        call lanes_sines_cosines(WIDEST, LANES, turns, sine, cosine)
        x = sine(1)
        c = cosine(1)
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
        h%year = [cosine(2), sine(2)]
        h%half_year = sum_of_angles(h%year, h%year)
        h%day = [cosine(3), sine(3)]
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
end module gracecg_environment_dtm
