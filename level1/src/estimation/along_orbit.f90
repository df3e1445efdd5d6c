!> Whether the linear accelerations have the unit and the signs that they should have: along the orbit, between the spans,
!> they follow air and light.
module gracecg_level1_along_orbit
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_base_statistics, only: median_of
    use gracecg_base_text, only: string_t
    use gracecg_environment_time, only: utc_of_gps
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_case_library, only: find_case
    use gracecg_simulation_case_models, only: build_dynamics
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, accelerations_t
    use gracecg_level1_between_records, only: orbit_at, attitude_at
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_folder, only: level1_folder_t
    use gracecg_level1_frames, only: srf_of_accelerometer
    use gracecg_level1_product_reading, only: find_files, read_product, without_bits
    use gracecg_level1_records, only: level1_records_t
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_time, only: level1_clock_t
    implicit none
    private
    public :: compare_along_orbit

contains

    !> Compares the samples of every minute within half a revolution of the spans with the models of the library, and notes
    !> in the calibration what they say by axis. Without SCA1B, or where the files hold too little, they say nothing.
    !>
    !> The air's density is hardly known beforehand (solar activity), light is to a third: each has a factor of its own. The
    !> unit is that by which light is seen, the sign that of the factor that is seen best.
    subroutine compare_along_orbit(paths, setup, clock, calibration)
        type(level1_folder_t), intent(in) :: paths
        type(level1_setup_t), intent(in) :: setup
        type(level1_clock_t), intent(in) :: clock
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
        type(satellite_dynamics_t) :: dynamics
        type(error_t), allocatable :: error
        real(dp), allocatable :: windows(:, :), times(:), seen(:, :), air(:, :), light(:, :), minutes(:)
        real(dp) :: t, sample(3)
        integer :: i, k, n
        logical :: known

        allocate (aside%notes(0))
        aside%satellite = calibration%satellite
        aside%epoch = calibration%epoch
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
        if (allocated(error) .or. acc%count == 0 .or. sca%count == 0 .or. gnv%count + gni%count == 0) return
        call acc%drop(.not. without_bits(acc, [0, 1, 3, 4, 6]))
        call sca%drop(.not. without_bits(sca, [0]))
        call acc%times_since(calibration%epoch, times)
        call build_models(setup, calibration%epoch, dynamics, error)
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
                seen(:, n) = srf_of_accelerometer(sample, setup%accelerometer_axes)
            end associate
        end do
        if (n < FEWEST) return
        do k = 1, 3
            call compare(minutes(:n), seen(k, :n), air(k, :n), light(k, :n), calibration%follows(k), &
                         calibration%light_seen(:, k))
        end do

    contains

        subroutine read_in(product, fields, margin, records)
            character(5), intent(in) :: product
            character(*), intent(in) :: fields(:)
            real(dp), intent(in) :: margin          ! s
            type(level1_records_t), intent(out) :: records

            type(string_t), allocatable :: found(:)
            real(dp) :: wider(2, size(windows, 2))

            call find_files(paths, [product], found)
            if (size(found) == 0 .or. allocated(error)) return
            wider(1, :) = windows(1, :) - margin
            wider(2, :) = windows(2, :) + margin
            call read_product(found, clock, aside, fields, records, error, wider)
        end subroutine read_in

        !> What air and light make in SRF, m/s^2.
        subroutine model_at(time, air, light, known)
            real(dp), intent(in) :: time            ! s
            real(dp), intent(out) :: air(3), light(3)
            logical, intent(out) :: known

            type(accelerations_t) :: acting
            real(dp) :: inertial(6), fixed(6), c(3, 3), q(4)

            associate (second => floor(time, i8))
                call attitude_at(sca, calibration%epoch + second, time - real(second, dp), q, known)
                if (known) call orbit_at(gnv, gni, calibration%epoch + second, time - real(second, dp), inertial, fixed, c, known)
            end associate
            if (.not. known) return
            call dynamics%accelerations(time, inertial(:3), inertial(4:), q, acting)
            air = matmul(rotation_matrix(q), acting%drag)
            light = matmul(rotation_matrix(q), acting%solar_radiation + acting%earth_radiation)
        end subroutine model_at
    end subroutine compare_along_orbit

    !> Air and light of the report's front satellite, plate by plate, with the mass that is said, from an epoch on.
    subroutine build_models(setup, epoch, dynamics, error)
        type(level1_setup_t), intent(in) :: setup
        integer(i8), intent(in) :: epoch            !! GPS, s past 2000-01-01 12:00
        type(satellite_dynamics_t), intent(out) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        type(case_t) :: case

        call find_case('front-1', case, error)
        if (allocated(error)) return
        case%epoch = utc_of_gps(epoch, 0.0_dp)
        case%earth_rotation = 'gmst-1982'
        case%gravity_model = 'point-mass'
        case%field_model = 'igrf14'
        case%space_weather = 'given'
        case%density_wave_random = .true.
        case%satellite%mass = setup%mass
        case%satellite%forces = 'plates'
        case%satellite%specular = 0.2_dp        ! between those of solar cells and of foil
        case%satellite%diffuse = 0.3_dp
        call build_dynamics(case, dynamics, error)
    end subroutine build_models

    !> What one axis says: the factors of air and light beside a bias and a drift, by least squares, with sigmas for residuals
    !> that hang together.
    subroutine compare(times, seen, air, light, follows, light_seen)
        real(dp), intent(in) :: times(:)            !! s
        real(dp), intent(in) :: seen(:), air(:), light(:)   !! m/s^2
        integer, intent(out) :: follows             !! 1; -1: with the opposite sign; 0: it does not tell
        real(dp), intent(out) :: light_seen(2)      !! Factor of light, and its sigma; 0: not known

        real(dp), parameter :: LEAST_SHARE = 0.5_dp     ! Of the variance that has to be explained
        real(dp), parameter :: CERTAIN = 5          ! Standard deviations
        type(error_t), allocatable :: error
        real(dp) :: rows(4, size(times)), normal(4, 4), rhs(4), x(4), covariance(4, 4), condition, left(size(times)), &
            drifting(size(times)), scale(4), together, ratio(2)
        integer :: i, n

        follows = 0
        light_seen = 0
        n = size(times)
        rows(1, :) = 1
        rows(2, :) = times - sum(times)/n
        rows(3, :) = air
        rows(4, :) = light
        scale = max(maxval(abs(rows), 2), tiny(1.0_dp))
        do i = 1, n
            rows(:, i) = rows(:, i)/scale
        end do
        call normal_equations(rows(:2, :), seen, normal(:2, :2), rhs(:2))
        call solve_normal_equations(normal(:2, :2), rhs(:2), x(:2), covariance(:2, :2), condition, error)
        if (allocated(error)) return
        drifting = seen - matmul(x(:2), rows(:2, :))
        call normal_equations(rows, seen, normal, rhs)
        call solve_normal_equations(normal, rhs, x, covariance, condition, error)
        if (allocated(error)) return
        left = seen - matmul(x, rows)
        together = max(0.0_dp, sum(left(2:)*left(:n - 1))/max(sum(left**2), tiny(1.0_dp)))
        covariance = covariance*sum(left**2)/(n - 4)*(1 + together)/(1 - min(together, 0.99_dp))
        ratio = x(3:)/sqrt(max([covariance(3, 3), covariance(4, 4)], tiny(1.0_dp)))
        if (sum(left**2) > (1 - LEAST_SHARE)*sum(drifting**2) .or. maxval(abs(ratio)) < CERTAIN) return
        follows = nint(sign(1.0_dp, ratio(maxloc(abs(ratio), 1))))
        light_seen = [x(4), sqrt(covariance(4, 4))]/scale(4)
    end subroutine compare
end module gracecg_level1_along_orbit
