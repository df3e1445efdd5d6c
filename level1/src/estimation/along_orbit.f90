!> Whether the linear accelerations have the unit and the signs that they should have: along the orbit, between the spans,
!> they follow air and light.
module gracecg_level1_along_orbit
    use gracecg_level1_basics
    use gracecg_base_constants, only: EARTH_ROTATION_RATE, DAYS_PER_CENTURY, HOUR_ANGLE, MJD_TO_JD
    use gracecg_environment_density_models, only: new_density_model, density_settings_t
    use gracecg_environment_earth_radiation, only: earth_radiation_t, earth_irradiance_t, new_earth_radiation, standard_rings, &
        EARTH_RADIATION_EPOCH_JD, DEFAULT_SOLAR_IRRADIANCE
    use gracecg_environment_earth_shape, only: earth_fixed_to_geodetic
    use gracecg_environment_space_weather, only: space_weather_source_t
    use gracecg_environment_sun, only: sun_position, conical_shadow
    use gracecg_environment_thermosphere, only: density_model_t, atmosphere_point_t, atmosphere_state_t
    use gracecg_environment_time, only: day_of_year, julian_centuries_tt, local_mean_solar_time
    use gracecg_spacecraft_plates, only: satellite_surface_t, new_trapezoid, REPORT_PRISM
    use gracecg_spacecraft_surface_loads, only: gas_t, wall_t, surface_load_t, mean_molar_mass, aerodynamic_load, &
        solar_radiation_load, earth_radiation_load
    use gracecg_level1_frames, only: orbit_at, attitude_at, srf_of_accelerometer, ORDERS
    use gracecg_level1_calibration, only: level1_calibration_t, find_files, read_product, without_bits, no_attitude
    use gracecg_level1_records, only: level1_records_t
    use gracecg_level1_series, only: take_away
    implicit none
    private
    public :: compare_along_orbit, compare_axis

    type :: surroundings_t
        !! Models of air and light, and the satellite in them
        type(utc_t) :: epoch                        !! Time 0
        class(density_model_t), allocatable :: air
        type(earth_radiation_t) :: earthlight
        type(satellite_surface_t) :: surface
        real(dp) :: mass = 0                        !! kg
    end type surroundings_t

contains

    !> Compares the samples of every minute within half a revolution of the spans with the models of the library, and notes
    !> in the calibration what they say by axis. Without SCA1B or GNV1B, or where the files hold too little, they say nothing.
    !>
    !> The air's density is hardly known beforehand (solar activity): x, along the flight, gives it. Light is known to a third:
    !> the unit is that by which it is seen. Where not all axes follow as they are, and do in another order, that is noted, too.
    subroutine compare_along_orbit(calibration)
        type(level1_calibration_t), intent(inout) :: calibration

        real(dp), parameter :: AROUND = 2900        ! s: half a revolution
        real(dp), parameter :: EVERY = 60, LENGTH = 2, APART = 5, NEAR = 2.5_dp     ! s
        real(dp), parameter :: ORBIT_MARGIN = 65    ! s: a record of every product
        integer, parameter :: FEWEST = 30           ! Minutes
        character(10), parameter :: LINEAR(4) = [character(10) :: 'lin_accl_x', 'lin_accl_y', 'lin_accl_z', 'qualflg'], &
            TURN(5) = [character(10) :: 'quatangle', 'quaticoeff', 'quatjcoeff', 'quatkcoeff', 'qualflg'], &
            STATE(6) = [character(10) :: 'xpos', 'ypos', 'zpos', 'xvel', 'yvel', 'zvel']
        type(level1_calibration_t) :: aside         ! takes the notes, which the spans have, too
        type(level1_records_t) :: acc, sca, gnv, gni
        type(surroundings_t) :: models
        type(error_t), allocatable :: error
        real(dp), allocatable :: windows(:, :), times(:), seen(:, :), air(:, :), light(:, :), minutes(:)
        real(dp) :: t, sample(3), unused(2, 3)
        integer :: i, k, n, follows(3)
        logical :: known

        allocate (aside%notes(0))
        aside%satellite = calibration%satellite
        aside%epoch = calibration%epoch
        aside%clock = calibration%clock
        associate (spans => calibration%spans)
            n = int((spans(size(spans))%stop - spans(1)%start + 2*AROUND)/EVERY)
            allocate (minutes(0))
            do i = 0, n
                t = spans(1)%start - AROUND + i*EVERY
                if (all(t < spans%start - APART .or. t > spans%stop + APART)) minutes = [minutes, t]
            end do
        end associate
        windows = reshape([(minutes(i) - LENGTH/2, minutes(i) + LENGTH/2, i=1, size(minutes))], [2, size(minutes)]) + &
            real(calibration%epoch, dp)
        call read_in('ACC1A', LINEAR, 0.0_dp, acc)
        call read_in('SCA1B', TURN, NEAR, sca)
        call read_in('GNV1B', STATE, ORBIT_MARGIN, gnv)
        call read_in('GNI1B', STATE, ORBIT_MARGIN, gni)
        if (allocated(error) .or. acc%count == 0 .or. sca%count == 0 .or. gnv%count == 0) return
        call acc%drop(.not. without_bits(acc, [0, 1, 3, 4, 6]))
        call sca%drop(no_attitude(sca) .or. .not. without_bits(sca, [0]))
        call acc%times_since(calibration%epoch, times)
        call build_models()
        if (allocated(error)) return
        allocate (seen(3, size(minutes)), air(3, size(minutes)), light(3, size(minutes)))
        n = 0
        do i = 1, size(minutes)
            associate (inside => abs(times - minutes(i)) < LENGTH/2)
                if (count(inside) < 5) cycle
                call model_at(minutes(i), air(:, n + 1), light(:, n + 1), known)
                if (.not. known) cycle
                n = n + 1
                minutes(n) = minutes(i)
                sample = [(median_of(pack(acc%values(:, k), inside)), k=1, 3)]     ! a firing does no harm
                seen(:, n) = srf_of_accelerometer(sample, calibration%setup%accelerometer_axes)
            end associate
        end do
        if (n < FEWEST) return
        call compare_axes(ORDERS(:, 1), calibration%follows, calibration%light_seen)
        if (all(calibration%follows /= 0)) return
        do i = 2, size(ORDERS, 2)
            call compare_axes(ORDERS(:, i), follows, unused)
            if (all(follows == 1)) calibration%order = ORDERS(:, i)
        end do

    contains

        !> The axes in an order: x, along the flight, gives the density for all.
        subroutine compare_axes(order, follows, light_seen)
            integer, intent(in) :: order(3)
            integer, intent(out) :: follows(3)
            real(dp), intent(out) :: light_seen(2, 3)

            real(dp) :: density
            integer :: axis

            density = -1
            do axis = 1, 3
                call compare_axis(minutes(:n), seen(order(axis), :n), air(axis, :n), light(axis, :n), density, follows(axis), &
                                  light_seen(:, axis))
            end do
        end subroutine compare_axes

        subroutine read_in(product, fields, margin, records)
            character(5), intent(in) :: product
            character(*), intent(in) :: fields(:)
            real(dp), intent(in) :: margin          ! s
            type(level1_records_t), intent(out) :: records

            type(string_t), allocatable :: found(:)
            real(dp) :: wider(2, size(windows, 2))

            call find_files(calibration, [product], found)
            if (size(found) == 0 .or. allocated(error)) return
            wider(1, :) = windows(1, :) - margin
            wider(2, :) = windows(2, :) + margin
            call read_product(found, aside, fields, records, error, wider)
        end subroutine read_in

        !> What air that turns with the Earth, and light of Sun and Earth, make plate by plate in SRF, m/s^2.
        subroutine model_at(time, air, light, known)
            real(dp), intent(in) :: time            ! s
            real(dp), intent(out) :: air(3), light(3)
            logical, intent(out) :: known

            real(dp), parameter :: CENTRE(3) = 0    ! no torques are wanted
            type(atmosphere_point_t) :: point
            type(atmosphere_state_t) :: state
            type(earth_irradiance_t) :: earthlight
            type(surface_load_t) :: load, sunlight
            real(dp) :: inertial(6), fixed(6), c(3, 3), q(4), to_body(3, 3), longitude, sun(3), flow(3)

            associate (second => floor(time, i8))
                call attitude_at(sca, calibration%epoch + second, time - real(second, dp), q, known)
                if (known) call orbit_at(gnv, gni, calibration%epoch + second, time - real(second, dp), inertial, fixed, c, known)
            end associate
            if (.not. known) return
            to_body = rotation_matrix(q)
            associate (epoch => models%epoch, r => inertial(:3))
                call earth_fixed_to_geodetic(fixed(:3), point%latitude, longitude, point%height)
                point%local_solar_time = local_mean_solar_time(epoch, 0.0_dp) + time/3600 + longitude/HOUR_ANGLE
                point%day_of_year = day_of_year(epoch) + time/SECONDS_PER_DAY
                call models%air%evaluate(point, state)
                flow = matmul(to_body, inertial(4:) - cross([0.0_dp, 0.0_dp, EARTH_ROTATION_RATE], r))
                load = aerodynamic_load(models%surface, CENTRE, gas_t(state%density, state%temperature, &
                                        mean_molar_mass([state%n_he, state%n_o, state%n_n2])), wall_t(), flow)
                air = load%force/models%mass
                sun = sun_position(julian_centuries_tt(epoch) + time/(SECONDS_PER_DAY*DAYS_PER_CENTURY))
                sunlight = solar_radiation_load(models%surface, CENTRE, DEFAULT_SOLAR_IRRADIANCE, conical_shadow(r, sun), &
                                                matmul(to_body, sun - r))
                call models%earthlight%irradiance_at(r, sun, epoch%mjd + (epoch%seconds + time)/SECONDS_PER_DAY + &
                                                     (MJD_TO_JD - EARTH_RADIATION_EPOCH_JD), earthlight)
                load = earth_radiation_load(models%surface, CENTRE, to_body, earthlight)
                light = (sunlight%force + load%force)/models%mass
            end associate
        end subroutine model_at

        !> Air and light about the satellite of CSR-TM-00-01 (section 5.2), with the mass that is said. Its plates
        !> reflect light as solar cells and foil do together, about.
        subroutine build_models()
            real(dp), parameter :: SPECULAR = 0.2_dp, DIFFUSE = 0.3_dp

            models%epoch = utc_of_gps(calibration%epoch, 0.0_dp)
            models%mass = calibration%setup%mass
            associate (prism => REPORT_PRISM)
                call new_trapezoid(prism(1), prism(2), prism(3), prism(4), SPECULAR, DIFFUSE, models%surface, error)
            end associate
            if (.not. allocated(error)) call new_earth_radiation('report', standard_rings(1), DEFAULT_SOLAR_IRRADIANCE, &
                                                                 models%earthlight, error)
            if (.not. allocated(error)) call new_density_model('dtm77', models%epoch, &
                density_settings_t(space_weather_source_t('given')), models%air, error)
        end subroutine build_models
    end subroutine compare_along_orbit

    !> What one axis says, all beside a bias and a drift, by least squares: whether air by its density and light by a factor of
    !> its own, or the opposite of both, explain it. The sigma is for residuals that hang together.
    subroutine compare_axis(times, seen, air, light, density, follows, light_seen)
        real(dp), intent(in) :: times(:)            !! s
        real(dp), intent(in) :: seen(:), air(:), light(:)   !! m/s^2
        real(dp), intent(inout) :: density          !! Of the air, by the model's; negative: not known, and found here
        integer, intent(out) :: follows             !! 1; -1: with the opposite sign; 0: it does not tell
        real(dp), intent(out) :: light_seen(2)      !! Factor of light, and its sigma; 0: not known

        real(dp), parameter :: LEAST_SHARE = 0.9_dp     ! Of the squares, that has to be explained: own sound days 0.937 to 0.996
        real(dp), parameter :: LEAST_LIGHT = 1/3.0_dp   ! Factor: by less the axis shows no light that could tell its sign
        real(dp), parameter :: MORE = 4             ! The opposite sign has to leave so many times as much
        type(error_t), allocatable :: error
        real(dp) :: rows(2, size(times)), normal(2, 2), rhs(2), x(2), covariance(2, 2), condition, left(size(times), -1:1), &
            drifting(size(times), 3), factor(-1:1), together
        integer :: i, n

        follows = 0
        light_seen = 0
        n = size(times)
        rows(1, :) = 1
        rows(2, :) = (times - sum(times)/n)/(times(n) - times(1))
        drifting = reshape([air, light, seen], [n, 3])
        do i = 1, 3
            call take_away(rows, drifting(:, i), error)
            if (allocated(error)) return
        end do
        if (density < 0) then
            call normal_equations(transpose(drifting(:, :2)), drifting(:, 3), normal, rhs)
            call solve_normal_equations(normal, rhs, x, covariance, condition, error)
            if (allocated(error)) return
            density = abs(x(1))
        end if
        do i = -1, 1, 2
            left(:, i) = drifting(:, 3) - i*density*drifting(:, 1)
            factor(i) = max(0.0_dp, i*sum(left(:, i)*drifting(:, 2))/max(sum(drifting(:, 2)**2), tiny(1.0_dp)))
            left(:, i) = left(:, i) - i*factor(i)*drifting(:, 2)
        end do
        i = merge(1, -1, sum(left(:, 1)**2) < sum(left(:, -1)**2))
        associate (best => left(:, i))
            if (sum(best**2) > (1 - LEAST_SHARE)*sum(drifting(:, 3)**2) .or. MORE*sum(best**2) > sum(left(:, -i)**2)) return
            if (factor(i) > LEAST_LIGHT) follows = i
            together = min(0.99_dp, max(0.0_dp, sum(best(2:)*best(:n - 1))/max(sum(best**2), tiny(1.0_dp))))
            light_seen = [factor(i), sqrt(sum(best**2)/(n - 4)/max(sum(drifting(:, 2)**2), tiny(1.0_dp))* &
                                          (1 + together)/(1 - together))]
        end associate
    end subroutine compare_axis
end module gracecg_level1_along_orbit
