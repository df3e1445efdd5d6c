!> Density models: published numbers, the physics they claim, and smoothness.
module test_thermosphere
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_is_finite
    use vocabulary
    use gracecg_environment_thermosphere, only: density_model_t, atmosphere_point_t, atmosphere_state_t, &
        density_wave_t
    use gracecg_environment_dtm, only: dtm_t, new_dtm
    use gracecg_environment_exponential_density, only: exponential_density_t, new_exponential_density
    implicit none
    private
    public :: collect_thermosphere

    ! Constants of DTM-77 (Barlier et al. 1978), for the identities
    real(dp), parameter :: RADIUS = 6356.77e3_dp, GAS_CONSTANT = 8.314_dp

contains

    subroutine collect_thermosphere(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('dtm77-points-of-the-listing', test_listing), &
                    new_unittest('dtm77-diffusive-equilibrium', test_equilibrium), &
                    new_unittest('dtm77-cyclic-in-local-time-and-year', test_cyclic), &
                    new_unittest('dtm77-smooth-over-the-poles', test_poles), &
                    new_unittest('dtm77-gradient-is-continuous', test_gradient), &
                    new_unittest('dtm77-finite-everywhere', test_finite), &
                    new_unittest('dtm77-below-its-lowest-height-and-nan', test_below), &
                    new_unittest('dtm77-indices-refused', test_indices), &
                    new_unittest('dtm78-points-of-cnes', test_cnes), &
                    new_unittest('dtm94-points', test_dtm94), &
                    new_unittest('dtm94-base-gradient-and-equilibrium', test_dtm94_profile), &
                    new_unittest('dtm94-kp-by-latitude', test_dtm94_kp), &
                    new_unittest('exponential', test_exponential), &
                    new_unittest('density-wave', test_wave)]
    end subroutine collect_thermosphere

    !> The model at the report's epoch.
    function epoch_model() result(model)
        type(dtm_t) :: model
        type(error_t), allocatable :: failure

        call new_dtm('dtm77', 185.7_dp, 210.6_dp, 2.7_dp, model, failure)
    end function epoch_model

    function state_at(model, height, latitude, local_solar_time, day_of_year) result(state)
        class(density_model_t), intent(in) :: model
        real(dp), intent(in) :: height, latitude    !! m, rad
        real(dp), intent(in) :: local_solar_time, day_of_year
        type(atmosphere_state_t) :: state

        call model%evaluate(atmosphere_point_t(height, latitude, local_solar_time, day_of_year), &
                            state)
    end function state_at

    real(dp) function density_at(model, height, latitude, local_solar_time, day_of_year)
        class(density_model_t), intent(in) :: model
        real(dp), intent(in) :: height, latitude    !! m, rad
        real(dp), intent(in) :: local_solar_time, day_of_year
        type(atmosphere_state_t) :: state

        state = state_at(model, height, latitude, local_solar_time, day_of_year)
        density_at = state%density
    end function density_at

    !> An edition at points as the two listings below have them: temperatures, number densities, density.
    subroutine compare(edition, points, error)
        character(*), intent(in) :: edition
        real(dp), intent(in) :: points(:, :)        ! (14, points)
        type(error_type), allocatable, intent(inout) :: error
        type(dtm_t) :: model
        type(error_t), allocatable :: failure
        type(atmosphere_state_t) :: state
        real(dp) :: gases(4)
        integer :: i

        do i = 1, size(points, 2)
            associate (p => points(:, i))
                call new_dtm(edition, p(2), p(3), p(4), model, failure)
                if (failed(error, failure)) return
                state = state_at(model, p(5)*1e3_dp, p(7)*DEGREE, p(6), p(1))
                if (edition == 'dtm77') then        ! its listing has O2, that of DTM-94 hydrogen
                    gases = [state%n_he, state%n_o, state%n_n2, state%n_o2]
                else
                    gases = [state%n_h, state%n_he, state%n_o, state%n_n2]
                end if
                call check(error, all(abs([state%temperature, state%exospheric_temperature, gases*1e-6_dp, &
                                           state%density]/p(8:14) - 1) < 1e-8_dp))
            end associate
        end do
    end subroutine compare

    !> The program printed in Aeronomica Acta A 185 (1977), appendix 1, keyed in, compiled and run
    !> in double precision: day, F10.7, its mean, Kp, height km, local time h, latitude deg, then
    !> temperature and exospheric temperature K, He, O, N2, O2 in 1/cm^3 and density kg/m^3.
    subroutine test_listing(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: POINTS(14, 7) = reshape([ &
            1.0_dp, 185.7_dp, 210.6_dp, 2.7_dp, 466.0_dp, 17.25_dp, 0.0_dp, &
            1316.017985_dp, 1317.268040_dp, 3.54655558e6_dp, 1.34187879e8_dp, 1.05648954e7_dp, &
            2.90630968e5_dp, 4.09481373e-12_dp, &
            1.0_dp, 185.7_dp, 210.6_dp, 2.7_dp, 466.0_dp, 4.50_dp, 10.0_dp, &
            1017.028182_dp, 1017.878935_dp, 4.70132786e6_dp, 7.98902419e7_dp, 1.26792590e6_dp, &
            2.50178329e4_dp, 2.21376379e-12_dp, &
            1.0_dp, 185.7_dp, 210.6_dp, 2.7_dp, 470.0_dp, 0.0_dp, 89.0_dp, &
            1021.967291_dp, 1022.764523_dp, 1.06465713e7_dp, 1.20315967e8_dp, 1.61964758e6_dp, &
            2.31619305e4_dp, 3.34340102e-12_dp, &
            172.0_dp, 150.0_dp, 150.0_dp, 2.0_dp, 300.0_dp, 15.0_dp, 45.0_dp, &
            1172.163486_dp, 1196.086101_dp, 2.64776255e6_dp, 7.11666081e8_dp, 2.89092408e8_dp, &
            1.37978221e7_dp, 3.30953677e-11_dp, &
            355.0_dp, 92.0_dp, 92.0_dp, 2.0_dp, 600.0_dp, 3.0_dp, -30.0_dp, &
            837.474931_dp, 837.531023_dp, 4.55108583e5_dp, 7.23973688e5_dp, 1.37931578e3_dp, &
            1.48294734e1_dp, 2.23195934e-14_dp, &
            80.0_dp, 200.0_dp, 150.0_dp, 4.0_dp, 120.0_dp, 12.0_dp, 20.0_dp, &
            380.0_dp, 1137.200763_dp, 7.08425119e7_dp, 1.72714184e11_dp, 4.43787028e11_dp, &
            4.775e10_dp, 2.77564755e-8_dp, &
            264.0_dp, 70.0_dp, 70.0_dp, 0.0_dp, 1000.0_dp, 9.0_dp, 60.0_dp, &
            809.807610_dp, 809.807681_dp, 1.39796374e5_dp, 3.16677674e2_dp, 2.01205259e-3_dp, &
            3.24729984e-6_dp, 9.36828253e-16_dp], [14, 7])
        call compare('dtm77', POINTS, error)
    end subroutine test_listing

    !> The program cps_atm_dtm78 of CNES, compiled and run with stub routines of dates: day, F10.7, its mean, Kp,
    !> height km, local time h, latitude deg, then density kg/m^3 and scale height rho/|d rho/dz| m.
    subroutine test_cnes(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: POINTS(9, 7) = reshape([ &
            1.0_dp, 185.7_dp, 210.6_dp, 2.66_dp, 466.0_dp, 17.25_dp, 0.0_dp, 4.52604458e-12_dp, 7.49393637e4_dp, &
            1.0_dp, 185.7_dp, 210.6_dp, 2.66_dp, 466.0_dp, 4.50_dp, 10.0_dp, 2.49564111e-12_dp, 6.16057513e4_dp, &
            1.0_dp, 185.7_dp, 210.6_dp, 2.66_dp, 470.0_dp, 0.0_dp, 89.0_dp, 3.54278433e-12_dp, 6.20575219e4_dp, &
            172.0_dp, 150.0_dp, 150.0_dp, 2.0_dp, 300.0_dp, 15.0_dp, 45.0_dp, 3.35871544e-11_dp, 5.09070804e4_dp, &
            355.0_dp, 92.0_dp, 92.0_dp, 2.0_dp, 600.0_dp, 3.0_dp, -30.0_dp, 2.39685106e-14_dp, 5.96353764e4_dp, &
            80.0_dp, 200.0_dp, 150.0_dp, 4.0_dp, 120.0_dp, 12.0_dp, 20.0_dp, 2.57189119e-8_dp, 8.55273062e3_dp, &
            264.0_dp, 70.0_dp, 70.0_dp, 0.0_dp, 1000.0_dp, 9.0_dp, 60.0_dp, 1.16028829e-15_dp, 2.68772736e5_dp], &
            [9, 7])
        real(dp), parameter :: STEP = 10.0_dp   ! m
        type(dtm_t) :: model
        type(error_t), allocatable :: failure
        real(dp) :: rho(3)
        integer :: i, k

        do i = 1, size(POINTS, 2)
            associate (p => POINTS(:, i))
                call new_dtm('dtm78', p(2), p(3), p(4), model, failure)
                if (failed(error, failure)) return
                rho = [(density_at(model, p(5)*1e3_dp + k*STEP, p(7)*DEGREE, p(6), p(1)), k=0, 2)]
                call check(error, rho(1)/p(8), 1.0_dp, thr=1e-8_dp)
                call check(error, rho(1)*2*STEP/(3*rho(1) - 4*rho(2) + rho(3))/p(9), 1.0_dp, thr=1e-5_dp)
            end associate
        end do
    end subroutine test_cnes

    !> DTM-94 at the points of the listing. The numbers are a separate evaluation of the published formulae from
    !> the same coefficients; with the constants of dtm94.m (GitHub lukasbystricky/SpaceSimulator: three-digit
    !> coefficients, masses of CODATA, gravity of the polar radius) that evaluation gives the four densities that
    !> this program gives at the fourth point, 3.6945E+04, 2.7182E+06, 5.9906E+08, 2.0513E+08 1/cm^3, to 3e-4.
    !> Day, F10.7, its mean, Kp, height km, local time h, latitude deg, then T, T_inf K, H, He, O, N2 1/cm^3,
    !> density kg/m^3.
    subroutine test_dtm94(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: POINTS(14, 7) = reshape([ &
            1.0_dp, 185.7_dp, 210.6_dp, 2.7_dp, 466.0_dp, 17.25_dp, 0.0_dp, &
            1.35180714780e+03_dp, 1.35979155052e+03_dp, 1.53727606763e+04_dp, 2.09415660051e+06_dp, &
            1.04666890807e+08_dp, 7.66779061737e+06_dp, 3.16163246144e-12_dp, &
            1.0_dp, 185.7_dp, 210.6_dp, 2.7_dp, 466.0_dp, 4.5_dp, 10.0_dp, &
            1.04569534496e+03_dp, 1.04625996031e+03_dp, 3.90688852837e+04_dp, 2.74430067469e+06_dp, &
            6.20595138264e+07_dp, 1.34190193181e+06_dp, 1.73125819585e-12_dp, &
            1.0_dp, 185.7_dp, 210.6_dp, 2.7_dp, 470.0_dp, 0.0_dp, 89.0_dp, &
            1.10323099402e+03_dp, 1.10423771803e+03_dp, 3.00518328044e+04_dp, 3.32436363414e+07_dp, &
            5.87232712571e+07_dp, 1.52236758484e+06_dp, 1.85422449388e-12_dp, &
            172.0_dp, 150.0_dp, 150.0_dp, 2.0_dp, 300.0_dp, 15.0_dp, 45.0_dp, &
            1.17485851180e+03_dp, 1.21630183308e+03_dp, 3.70702421483e+04_dp, 2.74279986474e+06_dp, &
            6.12618870807e+08_dp, 2.13707574499e+08_dp, 2.68386814773e-11_dp, &
            355.0_dp, 92.0_dp, 92.0_dp, 2.0_dp, 600.0_dp, 3.0_dp, -30.0_dp, &
            8.12830090946e+02_dp, 8.12830250452e+02_dp, 2.04068294941e+05_dp, 1.41314194076e+06_dp, &
            6.73966075971e+05_dp, 1.36123750852e+03_dp, 2.76917137905e-14_dp, &
            80.0_dp, 200.0_dp, 150.0_dp, 4.0_dp, 120.0_dp, 12.0_dp, 20.0_dp, &
            3.80000000000e+02_dp, 1.21216837487e+03_dp, 6.93003202069e+04_dp, 4.32100493357e+07_dp, &
            1.49512751245e+11_dp, 3.93577958616e+11_dp, 2.48058113872e-08_dp, &
            264.0_dp, 70.0_dp, 70.0_dp, 0.0_dp, 1000.0_dp, 9.0_dp, 60.0_dp, &
            7.83636151780e+02_dp, 7.83636151780e+02_dp, 1.51848593336e+05_dp, 1.35480217368e+05_dp, &
            2.40053051712e+02_dp, 1.10311533572e-03_dp, 1.15824245180e-15_dp], [14, 7])
        real(dp), parameter :: OTHER_PROGRAM(4) = [3.6945e4_dp, 2.7182e6_dp, 5.9906e8_dp, 2.0513e8_dp]
        type(dtm_t) :: model
        type(error_t), allocatable :: failure
        type(atmosphere_state_t) :: state

        call compare('dtm94', POINTS, error)
        associate (p => POINTS(:, 4))
            call new_dtm('dtm94', p(2), p(3), p(4), model, failure)
            state = state_at(model, p(5)*1e3_dp, p(7)*DEGREE, p(6), p(1))
        end associate
        ! its gravity alone makes 2 to 5 % of O and N2 there
        call check(error, all(abs([state%n_h, state%n_he, state%n_o, state%n_n2]*1e-6_dp/OTHER_PROGRAM - 1) < &
                              [0.01_dp, 0.01_dp, 0.03_dp, 0.05_dp]))
    end subroutine test_dtm94

    !> The temperature rises by 14.348 K/km at 120 km wherever it is, and every gas rests in its own weight.
    subroutine test_dtm94_profile(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: MASS(5) = [1e-3_dp, 4e-3_dp, 16e-3_dp, 28e-3_dp, 32e-3_dp]    ! kg/mol
        real(dp), parameter :: ALPHA(5) = [-0.38_dp, -0.38_dp, 0.0_dp, 0.0_dp, 0.0_dp], STEP = 20.0_dp   ! m
        type(dtm_t) :: model
        type(error_t), allocatable :: failure
        type(atmosphere_state_t) :: s(3)
        real(dp) :: height, gravity
        integer :: i, k

        call new_dtm('dtm94', 185.7_dp, 210.6_dp, 2.7_dp, model, failure)
        do i = 1, 24
            s(:2) = [(state_at(model, 120e3_dp + k*0.1_dp, (i - 12)*6*DEGREE, real(i, dp), 15.0_dp*i), k=0, 1)]
            call check(error, (s(2)%temperature - s(1)%temperature)/0.1_dp, 14.348e-3_dp, thr=1e-5_dp, rel=.true.)
            height = 140e3_dp + 30e3_dp*i
            s = [(state_at(model, height + k*STEP, 0.4_dp, real(i, dp), 15.0_dp*i), k=-1, 1)]
            gravity = 9.80665_dp*(RADIUS/(RADIUS + height))**2
            associate (below => numbers(s(1)), above => numbers(s(3)), weight => MASS*gravity/(GAS_CONSTANT*s(2)%temperature))
                call check(error, maxval(abs(log(above/below)/(2*STEP) + (1 + ALPHA)*log(s(3)%temperature/ &
                                                                         s(1)%temperature)/(2*STEP) + weight)/weight), &
                           0.0_dp, thr=1e-6_dp)
            end associate
        end do

    contains

        pure function numbers(state) result(n)
            type(atmosphere_state_t), intent(in) :: state
            real(dp) :: n(5)

            n = [state%n_h, state%n_he, state%n_o, state%n_n2, state%n_o2]
        end function numbers
    end subroutine test_dtm94_profile

    !> Kp of three hours before rules at the poles, that of six hours before at the equator, and half of each at
    !> 45 deg. The other editions know the one of three hours alone.
    subroutine test_dtm94_kp(error)
        type(error_type), allocatable, intent(out) :: error
        type(dtm_t) :: late, model(3)
        type(error_t), allocatable :: failure
        integer :: i

        call new_dtm('dtm94', 150.0_dp, 150.0_dp, 1.0_dp, late, failure, 5.0_dp)
        do i = 1, 3
            call new_dtm('dtm94', 150.0_dp, 150.0_dp, 2.0_dp*i - 1, model(i), failure)
            call check_passes(error, failure)
            call check(error, density_at(late, 460e3_dp, (3 - i)*PI/4, 3.0_dp, 10.0_dp)/ &
                       density_at(model(i), 460e3_dp, (3 - i)*PI/4, 3.0_dp, 10.0_dp), 1.0_dp, thr=1e-12_dp)
        end do
        call new_dtm('dtm77', 150.0_dp, 150.0_dp, 1.0_dp, late, failure, 5.0_dp)
        call new_dtm('dtm77', 150.0_dp, 150.0_dp, 1.0_dp, model(1), failure)
        call check(error, density_at(late, 460e3_dp, 0.0_dp, 3.0_dp, 10.0_dp), &
                   density_at(model(1), 460e3_dp, 0.0_dp, 3.0_dp, 10.0_dp), thr=0.0_dp)
        call new_dtm('dtm95', 150.0_dp, 150.0_dp, 1.0_dp, late, failure)
        call check_fails(error, failure, 'dtm94')
    end subroutine test_dtm94_kp

    !> Each gas rests in its own weight, d ln n/dz + (1 + alpha) d ln T/dz + M g/(R T) = 0 with
    !> gravity falling as 1/r^2: the equation whose solution the model's profile is. Central
    !> differences.
    subroutine test_equilibrium(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: MASS(4) = [4e-3_dp, 16e-3_dp, 28e-3_dp, 32e-3_dp]    ! kg/mol
        real(dp), parameter :: ALPHA(4) = [-0.38_dp, 0.0_dp, 0.0_dp, 0.0_dp]
        real(dp), parameter :: STEP = 20.0_dp   ! m
        type(dtm_t) :: model
        type(atmosphere_state_t) :: below, here, above
        real(dp) :: height, gravity, balance(4), weight(4), dlnt
        integer :: i

        model = epoch_model()
        do i = 125, 985, 20
            height = i*1e3_dp
            below = state_at(model, height - STEP, 0.4_dp, 14.0_dp, 1.0_dp)
            here = state_at(model, height, 0.4_dp, 14.0_dp, 1.0_dp)
            above = state_at(model, height + STEP, 0.4_dp, 14.0_dp, 1.0_dp)
            gravity = 9.80665_dp*(RADIUS/(RADIUS + height))**2
            weight = MASS*gravity/(GAS_CONSTANT*here%temperature)
            dlnt = log(above%temperature/below%temperature)/(2*STEP)
            balance = log([above%n_he/below%n_he, above%n_o/below%n_o, above%n_n2/below%n_n2, &
                           above%n_o2/below%n_o2])/(2*STEP) + (1 + ALPHA)*dlnt + weight
            call check(error, all(abs(balance/weight) < 1e-6_dp))
        end do
    end subroutine test_equilibrium

    subroutine test_cyclic(error)
        type(error_type), allocatable, intent(out) :: error
        type(dtm_t) :: model
        integer :: i

        model = epoch_model()
        do i = 0, 24
            call check(error, density_at(model, 466e3_dp, 0.7_dp, i - 24.0_dp, 1.0_dp), &
                       density_at(model, 466e3_dp, 0.7_dp, i + 0.0_dp, 1.0_dp), &
                       thr=1e-13_dp, rel=.true.)
        end do
        ! the afternoon is denser than the early morning
        call check(error, density_at(model, 466e3_dp, 0.0_dp, 15.0_dp, 1.0_dp) > &
                   1.5_dp*density_at(model, 466e3_dp, 0.0_dp, 4.0_dp, 1.0_dp))
        do i = 0, 365, 5
            call check(error, density_at(model, 466e3_dp, 0.7_dp, 9.0_dp, i + 365.0_dp), &
                       density_at(model, 466e3_dp, 0.7_dp, 9.0_dp, i + 0.0_dp), &
                       thr=1e-12_dp, rel=.true.)
        end do
    end subroutine test_cyclic

    !> At a pole the local time has no meaning. A path over it goes from local time t to t + 12 h,
    !> with the same slope before and after.
    subroutine test_poles(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: STEP = 1e-5_dp   ! rad
        type(dtm_t) :: model
        real(dp) :: at_pole, before, after, latitude, slope
        integer :: i, side

        model = epoch_model()
        do side = -1, 1, 2
            latitude = side*PI/2
            at_pole = density_at(model, 466e3_dp, latitude, 0.0_dp, 1.0_dp)
            do i = 0, 23
                call check(error, density_at(model, 466e3_dp, latitude, i + 0.0_dp, 1.0_dp), &
                           at_pole, thr=1e-13_dp, rel=.true.)
                before = density_at(model, 466e3_dp, latitude - side*STEP, i + 0.0_dp, 1.0_dp)
                after = density_at(model, 466e3_dp, latitude - side*STEP, i + 12.0_dp, 1.0_dp)
                slope = (after - before)/(2*STEP*at_pole)
                call check(error, (at_pole - before)/(STEP*at_pole), slope, thr=1e-4_dp)
            end do
        end do
    end subroutine test_poles

    !> One-sided differences agree wherever an input passes a place where a careless implementation
    !> has a seam: the equator, midnight, new year of the model, round figures.
    subroutine test_gradient(error)
        type(error_type), allocatable, intent(out) :: error

        ! of the height (m), latitude (rad), local time (h) and day; the changes of the gradient of
        ! ln(density) over a step, for a smooth function, are below TOLERANCE
        real(dp), parameter :: STEP(4) = [1.0_dp, 1e-5_dp, 1e-5_dp, 1e-5_dp]
        real(dp), parameter :: TOLERANCE(4) = [1e-8_dp, 1e-4_dp, 1e-5_dp, 1e-6_dp]
        real(dp), parameter :: SEAMS(4, 6) = reshape([ &
            466e3_dp, 0.0_dp, 0.0_dp, 0.0_dp, &
            466e3_dp, 0.0_dp, 24.0_dp, 365.0_dp, &
            466e3_dp, 0.7_dp, 12.0_dp, 182.5_dp, &
            500e3_dp, -0.7_dp, 6.0_dp, 1.0_dp, &
            200e3_dp, 0.5_dp, 18.0_dp, 366.0_dp, &
            150e3_dp, -1.2_dp, 3.0_dp, 90.0_dp], [4, 6])
        type(dtm_t) :: model
        real(dp) :: x(4), here, left, right
        integer :: i, k

        model = epoch_model()
        do i = 1, size(SEAMS, 2)
            here = at(SEAMS(:, i))
            do k = 1, 4
                x = SEAMS(:, i)
                x(k) = x(k) + STEP(k)
                right = (at(x) - here)/STEP(k)
                x(k) = SEAMS(k, i) - STEP(k)
                left = (here - at(x))/STEP(k)
                call check(error, abs(right - left) < TOLERANCE(k))
            end do
        end do

    contains

        real(dp) function at(place)
            real(dp), intent(in) :: place(4)

            at = log(density_at(model, place(1), place(2), place(3), place(4)))
        end function at
    end subroutine test_gradient

    !> Extreme activity, everywhere, all year: densities positive, temperatures of a thermosphere.
    subroutine test_finite(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: INDICES(3, 4) = reshape([ &
            60.0_dp, 60.0_dp, 0.0_dp, 60.0_dp, 60.0_dp, 9.0_dp, &
            400.0_dp, 250.0_dp, 9.0_dp, 250.0_dp, 250.0_dp, 0.0_dp], [3, 4])
        type(dtm_t) :: model
        type(error_t), allocatable :: failure
        type(atmosphere_state_t) :: s
        integer :: i, latitude, hour, day

        do i = 1, size(INDICES, 2)
            call new_dtm('dtm77', INDICES(1, i), INDICES(2, i), INDICES(3, i), model, failure)
            if (failed(error, failure)) return
            do latitude = -90, 90, 15
                do hour = 0, 21, 3
                    do day = 0, 365, 73
                        s = state_at(model, 466e3_dp, latitude*DEGREE, hour + 0.0_dp, day + 0.0_dp)
                        call check(error, ieee_is_finite(s%density) .and. s%density > 1e-15_dp &
                                   .and. s%density < 1e-9_dp .and. s%temperature > 400 .and. &
                                   s%temperature < 4000)
                    end do
                end do
            end do
        end do
    end subroutine test_finite

    !> The caller learns the limit; below it the state is that of the limit, never NaN. An input that is not a number
    !> gives a density that is not a number, for each input.
    subroutine test_below(error)
        type(error_type), allocatable, intent(out) :: error
        type(dtm_t) :: model

        model = epoch_model()
        call check(error, model%lowest_height(), 120e3_dp)
        call check(error, density_at(model, 50e3_dp, 0.4_dp, 14.0_dp, 1.0_dp), &
                   density_at(model, 120e3_dp, 0.4_dp, 14.0_dp, 1.0_dp))
        call check(error, all(ieee_is_nan([density_at(model, NAN, 0.4_dp, 14.0_dp, 1.0_dp), &
                                           density_at(model, 466e3_dp, NAN, 14.0_dp, 1.0_dp), &
                                           density_at(model, 466e3_dp, 0.4_dp, NAN, 1.0_dp), &
                                           density_at(model, 466e3_dp, 0.4_dp, 14.0_dp, NAN)])))
    end subroutine test_below

    !> Each with a word that its message must hold.
    subroutine test_indices(error)
        type(error_type), allocatable, intent(out) :: error
        character(12), parameter :: WORDS(7) = [character(12) :: 'f107 = 0', 'f107 = NaN', &
            'f107_mean = ', 'f107_mean = ', 'kp = 27', 'kp = NaN', 'too far']
        real(dp) :: indices(3, 7)
        type(dtm_t) :: model
        type(error_t), allocatable :: failure
        integer :: i

        indices = reshape([0.0_dp, 150.0_dp, 2.0_dp, NAN, 150.0_dp, 2.0_dp, &
                           150.0_dp, 501.0_dp, 2.0_dp, 150.0_dp, NAN, 2.0_dp, &
                           150.0_dp, 150.0_dp, 27.0_dp, 150.0_dp, 150.0_dp, NAN, &
                           50.0_dp, 450.0_dp, 2.0_dp], [3, 7])
        do i = 1, size(WORDS)
            call new_dtm('dtm77', indices(1, i), indices(2, i), indices(3, i), model, failure)
            call check_fails(error, failure, WORDS(i))
        end do
    end subroutine test_indices

    !> rho_0 at h_0, rho_0/e a scale height above; the temperature belongs to the scale height:
    !> pressure = n k T falls by its own weight, d ln p/dh = -m g/(k T) at the reference height.
    subroutine test_exponential(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: BOLTZMANN = 1.380649e-23_dp      ! J/K
        type(exponential_density_t) :: model
        type(error_t), allocatable :: failure
        type(atmosphere_state_t) :: s
        real(dp) :: gravity

        call new_exponential_density(4e-12_dp, 466e3_dp, 70e3_dp, model, failure)
        if (failed(error, failure)) return
        s = state_at(model, 466e3_dp, 0.4_dp, 14.0_dp, 1.0_dp)
        call check(error, s%density, 4e-12_dp)
        call check(error, density_at(model, 536e3_dp, -1.0_dp, 3.0_dp, 200.0_dp), &
                   4e-12_dp*exp(-1.0_dp), thr=1e-15_dp, rel=.true.)
        gravity = 398600.4415e9_dp/(6371e3_dp + 466e3_dp)**2
        call check(error, s%density*gravity/(s%n_o*BOLTZMANN*s%temperature), 1/70e3_dp, &
                   thr=0.01_dp, rel=.true.)
        call check(error, model%lowest_height() < 0)
        call new_exponential_density(-4e-12_dp, 466e3_dp, 70e3_dp, model, failure)
        call check(error, allocated(failure))
        call new_exponential_density(4e-12_dp, -1.0_dp, 70e3_dp, model, failure)
        call check(error, allocated(failure))
        call new_exponential_density(4e-12_dp, 466e3_dp, 0.0_dp, model, failure)
        call check(error, allocated(failure))
    end subroutine test_exponential

    !> Zero, crest and trough where a sine has them; no wave unless one is asked for.
    subroutine test_wave(error)
        type(error_type), allocatable, intent(out) :: error
        type(density_wave_t) :: wave

        call check(error, wave%relative_change(3.0_dp), 0.0_dp)
        wave = density_wave_t(0.003_dp, 12.0_dp, PI/2)
        call check(error, wave%relative_change(0.0_dp), 0.003_dp, thr=1e-17_dp)
        call check(error, wave%relative_change(3.0_dp), 0.0_dp, thr=1e-17_dp)
        call check(error, wave%relative_change(30.0_dp), -0.003_dp, thr=1e-17_dp)
    end subroutine test_wave
end module test_thermosphere
