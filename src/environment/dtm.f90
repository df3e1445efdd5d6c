!> The Drag Temperature Models: DTM-77 of Barlier et al. (1978), which CSR-TM-00-01 section 2.3.2.1 takes,
!> DTM-78 as CNES has it, and DTM-94 of Berger et al. (1998).
module gracecg_environment_dtm
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI, PI
    use gracecg_base_error, only: error_t, fail, fail_unknown_name, number_text, require_range
    use gracecg_base_lanes, only: LANES, lanes_sines_cosines, lanes_exponentials
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

    !> Lanes of the expansions that lie side by side. That of the temperature serves molecular oxygen after it, which has no
    !> expansion; what no lane is named for is 0
    integer, parameter :: TEMPERATURE = 1, MOLECULAR_OXYGEN = 1, HELIUM = 2, OXYGEN = 3, NITROGEN = 4, HYDROGEN = 5

    !> Columns of an expansion G(L): the coefficients A(1..39), of which the earlier editions have 36;
    !> what stands by exp(Kp); and what does not depend on the point, worked out: 1 + F1, the factor of the annual and daily
    !> terms, and phases of annual and semiannual terms as [cosine, sine]
    integer, parameter :: TERMS = 39, EXPONENTIAL_KP = 40, FLUX = 41, BETA = 42, ANNUAL(2) = [43, 44], SEMIANNUAL(2) = [45, 46], &
        ANTISYMMETRIC_ANNUAL(2) = [47, 48], ANTISYMMETRIC_SEMIANNUAL(2) = [49, 50], COLUMNS = 50

    !> Functions of place and time that the expansions share: Legendre functions of the sine of
    !> the latitude (not normalised, without the factor (-1)^m), cosines and sines.
    type :: harmonics_t
        real(dp) :: p10, p20, p30, p40, p50, p11, p21, p31, p51, p22, p32, p33
        ! [cosine, sine] of the day in the year, of twice it, and of one to three times the hour
        real(dp) :: year(2), half_year(2), day(2), half_day(2), third_day(2)
        real(dp) :: kp, exponential_kp    !! Kp of the place, see dtm_t, and where an edition has it, exp(Kp)
    end type harmonics_t

    type, extends(density_model_t) :: dtm_t
        !! A Drag Temperature Model for given solar and geomagnetic activity; made by `new_dtm`
        private
        real(dp) :: columns(LANES, COLUMNS) = 0         !! Of the expansions
        real(dp) :: base_density(LANES) = 0             !! At 120 km, A(1) of a constituent, 1/cm^3
        real(dp) :: thermal_diffusion(LANES) = 0        !! alpha; 0 for O, N2, O2
        real(dp) :: kp_pole, kp_equator     !! Kp three hours before; DTM-94: at the pole, six at the equator
        real(dp) :: gas_constant = GAS_CONSTANT         !! J/(mol K)
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
    real(dp), parameter :: MASS(LANES) = [MASS_O2, MASS_HE, MASS_O, MASS_N2, MASS_H, 0.0_dp, 0.0_dp, 0.0_dp]
    real(dp), parameter :: THERMAL_DIFFUSION_HE = -0.38_dp
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
            call set_expansion(model, TEMPERATURE, DTM77_TEMPERATURE, f107, f107_mean)
            call set_expansion(model, HELIUM, DTM77_HELIUM, f107, f107_mean)
            call set_expansion(model, OXYGEN, DTM77_OXYGEN, f107, f107_mean)
            call set_expansion(model, NITROGEN, DTM77_NITROGEN, f107, f107_mean)
        case ('dtm78')
            call set_expansion(model, TEMPERATURE, DTM78_TEMPERATURE, f107, f107_mean)
            call set_expansion(model, HYDROGEN, DTM78_HYDROGEN, f107, f107_mean)
            call set_expansion(model, HELIUM, DTM78_HELIUM, f107, f107_mean)
            call set_expansion(model, OXYGEN, DTM78_OXYGEN, f107, f107_mean)
            call set_expansion(model, NITROGEN, DTM78_NITROGEN, f107, f107_mean)
            model%gas_constant = GAS_CONSTANT_78
            model%thermal_diffusion(HYDROGEN) = THERMAL_DIFFUSION_H_78
        case ('dtm94')
            call set_expansion(model, TEMPERATURE, DTM94_TEMPERATURE, f107, f107_mean)
            call set_expansion(model, HYDROGEN, DTM94_HYDROGEN, f107, f107_mean)
            call set_expansion(model, HELIUM, DTM94_HELIUM, f107, f107_mean)
            call set_expansion(model, OXYGEN, DTM94_OXYGEN, f107, f107_mean)
            call set_expansion(model, NITROGEN, DTM94_NITROGEN, f107, f107_mean)
            model%columns(TEMPERATURE, EXPONENTIAL_KP) = model%columns(TEMPERATURE, TERMS)  ! A(39) exp(Kp), not A(39) Kp^2
            model%columns(TEMPERATURE, TERMS) = 0
            model%thermal_diffusion(HYDROGEN) = THERMAL_DIFFUSION_H_94
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
        model%base_density = model%columns(:, 1)
        model%base_density(MOLECULAR_OXYGEN) = BASE_DENSITY_O2
        model%thermal_diffusion(HELIUM) = THERMAL_DIFFUSION_HE
        model%columns([HYDROGEN, HELIUM], BETA) = 1
        associate (t => model%columns(TEMPERATURE, :))
            mean_temperature = t(1)*(t(FLUX) + t(7)*kp)
        end associate
        if (mean_temperature < LOWEST_MEAN_TEMPERATURE) then
            call fail(error, 'f107 = '//number_text(f107)//' and f107_mean = '// &
                      number_text(f107_mean)//' sfu are too far apart for '//edition//': they give a '// &
                      'mean exospheric temperature of '//number_text(mean_temperature)// &
                      ' K; a day''s flux lies within some 100 sfu of its 81-day mean')
        end if
    end subroutine new_dtm

    !> The coefficients of an expansion, and the part that does not depend on the point: F1 and the annual phases.
    pure subroutine set_expansion(model, lane, a, f107, f107_mean)
        type(dtm_t), intent(inout) :: model
        integer, intent(in) :: lane
        real(dp), intent(in) :: a(:)            !! As many as the edition has
        real(dp), intent(in) :: f107, f107_mean

        real(dp) :: f1

        associate (e => model%columns(lane, :))
            e(:size(a)) = a
            f1 = a(4)*(f107 - f107_mean) + a(5)*(f107 - f107_mean)**2 + a(6)*(f107_mean - MEAN_FLUX) + &
                 e(38)*(f107_mean - MEAN_FLUX)**2
            e(BETA) = 1 + f1
            e(FLUX) = 1 + f1
            e(ANNUAL) = cosine_sine(TWO_PI*a(11)/YEAR)
            e(SEMIANNUAL) = cosine_sine(2*TWO_PI*a(14)/YEAR)
            e(ANTISYMMETRIC_ANNUAL) = cosine_sine(TWO_PI*a(18)/YEAR)
            e(ANTISYMMETRIC_SEMIANNUAL) = cosine_sine(2*TWO_PI*a(20)/YEAR)
        end associate
    end subroutine set_expansion

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
        real(dp), dimension(LANES) :: g, gamma, exponent, n

        h = harmonics_of(point)
        h%kp = self%kp_pole + (self%kp_equator - self%kp_pole)*(1 - abs(point%latitude)/(PI/2))
        if (self%with_gradient) h%exponential_kp = exp(h%kp)
        height = point%height
        if (height < BASE_HEIGHT) height = BASE_HEIGHT      ! and not max(), which may drop a NaN
        geopotential_height = (height - BASE_HEIGHT)*BASE_RADIUS/(EARTH_RADIUS + height)

        g = expansions(self%columns, h)
        t_inf = self%columns(TEMPERATURE, 1)*g(TEMPERATURE)
        rate = SIGMA
        if (self%with_gradient) rate = BASE_GRADIENT_94/(t_inf - BASE_TEMPERATURE)
        gamma_factor = 1e-3_dp*BASE_GRAVITY/(rate*self%gas_constant)
        state%exospheric_temperature = t_inf
        state%temperature = t_inf - (t_inf - BASE_TEMPERATURE)*exp(-rate*geopotential_height)
        log_temperature_ratio = log(BASE_TEMPERATURE/state%temperature)

        ! n = A(1) exp(G - 1) (T120/T)^(1 + alpha + gamma) exp(-sigma gamma xi) in 1/m^3: the two
        ! powers and the exponential in one.
        g(MOLECULAR_OXYGEN) = 1
        gamma = MASS*(gamma_factor/t_inf)
        exponent = g - 1 - rate*geopotential_height*gamma + (1 + self%thermal_diffusion + gamma)*log_temperature_ratio
        call lanes_exponentials(exponent, n)
        n = self%base_density*PER_CUBIC_METRE*n
        state%n_he = n(HELIUM)
        state%n_o = n(OXYGEN)
        state%n_n2 = n(NITROGEN)
        state%n_o2 = n(MOLECULAR_OXYGEN)
        state%n_h = n(HYDROGEN)
        state%density = ATOMIC_MASS_UNIT*(MASS_HE*state%n_he + MASS_O*state%n_o + &
                                          MASS_N2*state%n_n2 + MASS_O2*state%n_o2 + MASS_H*state%n_h)
    end subroutine evaluate_dtm

    !> G(L) = 1 + F1 + M + Q + beta (AN1 + SAN1 + AN2 + SAN2 + D + SD + TD), Barlier et al. (1978), of the expansions side by
    !> side; A(37) P10 in Q and A(39) Kp^2, or exp(Kp) with a column of its own, in M are of DTM-94.
    pure function expansions(a, h) result(g)
        real(dp), intent(in) :: a(LANES, COLUMNS)
        type(harmonics_t), intent(in) :: h
        real(dp) :: g(LANES)

        real(dp) :: steady, yearly, half_yearly, season, half_season, antisymmetric, diurnal, semidiurnal, terdiurnal
        integer :: l

        do l = 1, LANES
            steady = a(l, FLUX) + a(l, 7)*h%kp + (a(l, 2) + a(l, 8)*h%kp)*h%p20 + a(l, 3)*h%p40 + a(l, 37)*h%p10 + &
                     a(l, 39)*h%kp**2 + a(l, EXPONENTIAL_KP)*h%exponential_kp
            yearly = (a(l, 9) + a(l, 10)*h%p20)*(a(l, ANNUAL(1))*h%year(1) + a(l, ANNUAL(2))*h%year(2))
            half_yearly = (a(l, 12) + a(l, 13)*h%p20)* &
                          (a(l, SEMIANNUAL(1))*h%half_year(1) + a(l, SEMIANNUAL(2))*h%half_year(2))
            season = a(l, ANTISYMMETRIC_ANNUAL(1))*h%year(1) + a(l, ANTISYMMETRIC_ANNUAL(2))*h%year(2)
            half_season = a(l, ANTISYMMETRIC_SEMIANNUAL(1))*h%half_year(1) + &
                          a(l, ANTISYMMETRIC_SEMIANNUAL(2))*h%half_year(2)
            antisymmetric = (a(l, 15)*h%p10 + a(l, 16)*h%p30 + a(l, 17)*h%p50)*season + a(l, 19)*h%p10*half_season
            diurnal = &
                (a(l, 21)*h%p11 + a(l, 22)*h%p31 + a(l, 23)*h%p51 + (a(l, 24)*h%p11 + a(l, 25)*h%p21)*season)*h%day(1) + &
                (a(l, 26)*h%p11 + a(l, 27)*h%p31 + a(l, 28)*h%p51 + (a(l, 29)*h%p11 + a(l, 30)*h%p21)*season)*h%day(2)
            semidiurnal = (a(l, 31)*h%p22 + a(l, 32)*h%p32*season)*h%half_day(1) + &
                          (a(l, 33)*h%p22 + a(l, 34)*h%p32*season)*h%half_day(2)
            terdiurnal = h%p33*(a(l, 35)*h%third_day(1) + a(l, 36)*h%third_day(2))
            g(l) = steady + a(l, BETA)*(yearly + half_yearly + antisymmetric + diurnal + semidiurnal + terdiurnal)
        end do
    end function expansions

    pure function harmonics_of(point) result(h)
        type(atmosphere_point_t), intent(in) :: point
        type(harmonics_t) :: h

        real(dp), dimension(LANES) :: turns, sine, cosine
        real(dp) :: x, c, x2, x4

        h%exponential_kp = 0
        turns = 0
        turns(:3) = [point%latitude/TWO_PI, point%day_of_year/YEAR, point%local_solar_time/24]
        call lanes_sines_cosines(turns, sine, cosine)
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
