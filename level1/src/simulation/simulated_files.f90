!> A simulated folder of Level-1 files: what GRACE or GRACE-FO would have delivered of a flight, with the errors of clocks
!> and instruments.
!>
!>     call new_level1_truth(case, settings, seed, run, truth, error)
!>     call write_level1_folder(truth, 'day', .false., written, error)
!>
!> Tags of 1A files are those of the on-board computer; times of the truth are GPS. Text is that of GRACE-FO (C, D) or
!> GRACE (A, B); binary that of GRACE, but for what has no binary form (IMU1A, and SCA1A of GRACE-FO), which stays text.
module gracecg_level1_simulated_files
    use gracecg_level1_basics
    use gracecg_base_constants, only: EARTH_ROTATION_RATE, MICROTESLA, PI
    use gracecg_base_quaternion, only: conjugate_quaternion, quaternion_of_matrix
    use gracecg_base_random, only: random_stream_t
    use gracecg_base_vectors, only: unit
    use gracecg_level1_day_dynamics, only: PAIRS
    use gracecg_level1_products, only: satellite_of_grace_fo
    use gracecg_level1_simulated_folder, only: level1_folder_t, write_events, write_setup, write_truth
    use gracecg_level1_simulated_truth, only: level1_truth_t, truth_point_t, HOLD, FIRST_TAG
    use gracecg_level1_simulation_settings, only: by_satellite
    use gracecg_simulation_dynamics, only: POSITION, VELOCITY, ATTITUDE, STATE_SIZE
    implicit none
    private
    public :: write_level1_folder

    ! Where nothing else is said numbers are those of the files of GRACE-FO C, 2023-06-01, and of GRACE, 2003-09-14; flags,
    ! counts and channels that nothing is made of are copied from them
    real(dp), parameter :: ACCELEROMETER_INTERVAL = 0.0999910_dp    ! of ACC1A, s
    real(dp), parameter :: FIRST_SAMPLE = 0.007739_dp   ! s
    real(dp), parameter :: HEAD_TAG = 0.03_dp           ! of SCA1A, s
    real(dp), parameter :: GYRO_INTERVAL = 0.125_dp, GYRO_TAG = 0.004_dp, GYRO_STEP = 0.001126_dp   ! of IMU1A, s
    integer, parameter :: HEADS = 3, GYROS = 3          ! gyros of four: one is off

    !> What the rods add to the magnetometer, nT/mA, axis and rod: GRACE-A
    real(dp), parameter :: ROD_FIELD(3, 3) = reshape([3.1_dp, -37.7_dp, 37.3_dp, -3.0_dp, -5.1_dp, -1.4_dp, &
                                                      -23.2_dp, -1.0_dp, 2.4_dp], [3, 3])
    !> Biases of the magnetometers of A to D, nT; B is taken as A
    real(dp), parameter :: MAGNETOMETER_BIAS(3, 4) = reshape([ &
        267.0_dp, -2615.0_dp, -2722.0_dp, 267.0_dp, -2615.0_dp, -2722.0_dp, -530.0_dp, 16.0_dp, 250.0_dp, &
        1132.0_dp, 157.0_dp, -431.0_dp], [3, 4])
    !> Boresights of the star cameras' heads of GRACE-FO in SRF; those of GRACE lie 45 deg above the x-y plane, to both sides
    real(dp), parameter :: BORESIGHTS(3, HEADS) = reshape([0.508_dp, 0.0_dp, -0.861_dp, -0.460_dp, 0.763_dp, -0.454_dp, &
                                                           -0.444_dp, -0.769_dp, -0.459_dp], [3, HEADS])
    real(dp), parameter :: BORESIGHTS_OF_GRACE(3, 2) = reshape([0, 1, -1, 0, -1, -1], [3, 2])
    !> Axes of the gyros: three of a tetrahedron, of which one does not see the orbital rate
    real(dp), parameter :: GYRO_AXES(3, GYROS) = reshape([ &
        0.5773502691896258_dp, 0.816496580927726_dp, 0.0_dp, -0.5773502691896258_dp, 0.0_dp, 0.816496580927726_dp, &
        0.5773502691896258_dp, -0.816496580927726_dp, 0.0_dp], [3, GYROS])

    integer, parameter :: NOISE_ACCELEROMETER = 11, NOISE_MAGNETOMETER = 12, NOISE_ATTITUDE = 13, NOISE_HEADS = 14, &
        NOISE_GYROS = 15, WRONG = 17    ! streams of random numbers

contains

    !> Writes all files of a run into a folder that is there. After a failure none of them is left.
    subroutine write_level1_folder(truth, name, binary, written, error)
        type(level1_truth_t), intent(in) :: truth
        character(*), intent(in) :: name            !! Of the folder
        logical, intent(in) :: binary               !! GRACE's binary records, where there are such
        type(string_t), allocatable, intent(out) :: written(:)  !! Names of the files
        type(error_t), allocatable, intent(out) :: error

        type(level1_folder_t) :: folder

        folder%name = trim(name)
        folder%satellite = truth%satellite
        folder%grace_fo = satellite_of_grace_fo(folder%satellite)
        folder%binary = binary
        folder%epoch = truth%epoch
        allocate (folder%written(0))
        call write_accelerometer(truth, folder)
        call write_currents(truth, folder)
        call write_attitude(truth, folder)
        call write_heads(truth, folder)
        if (folder%grace_fo) call write_gyros(truth, folder)
        call write_orbit(truth, folder)
        call write_clocks(truth, folder)
        call write_thrusters(truth, folder)
        call write_tanks(truth, folder)
        call write_events(truth, folder)
        call write_setup(truth, folder)
        call write_truth(truth, folder)
        if (allocated(folder%failure)) call folder%remove()
        call move_alloc(folder%written, written)
        call move_alloc(folder%failure, error)
        call add_context(error, 'simulated Level-1 files')
    end subroutine write_level1_folder

    !> The accelerometer: linear and angular accelerations through scale, bias, leakage, noise and quanta. Noise of the
    !> linear axes is white with differences of white noise, whose one-sided density is
    !>
    !>     S(f) = a^2 + b^2 (2 sin(pi f dt))^2
    !>
    !> with the densities at 0.1 Hz and, as a mean, from 2 to 5 Hz that the settings have.
    subroutine write_accelerometer(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        real(dp), parameter :: FACTORS(4) = [1, 1, 1, 6]    ! Of noise: A to D
        integer, parameter :: PRODUCTS = int(b'00000100000000000000000000111111')   ! Accelerations and block number
        integer, parameter :: NO_MAPPING = int(b'01000000'), BLOCKS = 65536
        real(dp), parameter :: WRONG_BY = 1e-6_dp           ! m/s^2, of flagged samples: a thousand times the noise
        real(dp), parameter :: EARLIER = 30                 ! s: transplanted data are of another satellite, as GRACE's are apart
        integer, parameter :: AF_IN_SRF(6) = [2, 3, 1, 5, 6, 4]     ! x, y, z of AF are y, z, x of SRF
        type(random_stream_t) :: stream
        type(truth_point_t) :: point, other
        real(dp), allocatable :: tags(:)
        logical, allocatable :: missing(:), flagged(:)
        real(dp) :: white(3), steep(3), before(3), now(3), both(6), noise(6), time, factor, angular_sigma(3)
        integer :: n, k, axis

        associate (settings => truth%settings, drawn => truth%errors)
            n = floor((truth%duration - 1)/ACCELEROMETER_INTERVAL)
            tags = [(FIRST_SAMPLE + k*ACCELEROMETER_INTERVAL, k=0, n - 1)]
            call choose_wrong(truth, tags, missing, flagged)
            factor = settings%noise_factor
            if (factor < 0) factor = by_satellite(folder%satellite, FACTORS)
            call noise_sigmas(factor*settings%noise_low, factor*settings%noise_high, white, steep)
            angular_sigma = factor*settings%angular_noise/sqrt(2*ACCELEROMETER_INTERVAL)
            call folder%begin('ACC1A', count(.not. missing), tags(1), tags(n))
            stream = truth%stream(NOISE_ACCELEROMETER)
            before = 0
            do k = 1, n
                call folder%tag(tags(k), time)
                time = truth%gps_of_obc(time) - settings%accelerometer_delay
                call truth%at(time, point)
                do axis = 1, 3
                    now(axis) = steep(axis)*stream%normal()
                    noise(axis) = white(axis)*stream%normal() + now(axis) - before(axis)
                    noise(3 + axis) = angular_sigma(axis)*stream%normal()
                end do
                before = now
                both = [settings%bias + drawn%scale*truth%as_aligned(time, point%sensed) + matmul(drawn%leak, point%current) + &
                        matmul(drawn%leak_rate, point%current_rate), &
                        settings%angular_bias + drawn%angular_scale*truth%as_aligned(time, point%acceleration) + &
                        matmul(drawn%angular_leak, point%current) + matmul(drawn%angular_leak_rate, point%current_rate)] + noise
                both(4:) = in_quanta(settings%angular_quantum, both(4:))
                if (settings%fault == 'transplanted') then
                    call truth%at(time - min(time, EARLIER), other)
                    both(1:2) = settings%bias(1:2) - other%sensed(1:2)
                    both(4:) = 0
                end if
                if (missing(k)) cycle
                if (flagged(k)) both(:3) = both(:3) + WRONG_BY
                if (settings%fault /= 'srf-as-af') both = both(AF_IN_SRF)
                call folder%put('prod_flag', [real(PRODUCTS, dp)])
                call folder%put('qualflg', [real(merge(NO_MAPPING, 0, flagged(k)), dp)])
                if (settings%fault == 'obc-tags') call folder%put('time_ref', [real(iachar('G'), dp)])
                call folder%put('lin_accl_x', both)
                call folder%put('icu_blk_nr', [real(modulo(k - 1, BLOCKS), dp)])
                call folder%record()
            end do
        end associate
        call folder%finish()
    end subroutine write_accelerometer

    !> A value in whole quanta; 0: as it is.
    elemental real(dp) function in_quanta(quantum, value)
        real(dp), intent(in) :: quantum, value      !! Of one unit

        in_quanta = value
        if (quantum > 0) in_quanta = quantum*anint(value/quantum)
    end function in_quanta

    !> Standard deviations of the white noise and of that whose differences are taken, by sample.
    pure subroutine noise_sigmas(low, high, white, steep)
        real(dp), intent(in) :: low(3), high(3)         !! m/s^2/sqrt(Hz), one-sided
        real(dp), intent(out) :: white(3), steep(3)     !! m/s^2

        real(dp), parameter :: LOW_FREQUENCY = 0.1_dp, HIGH_BAND(2) = [2.0_dp, 5.0_dp]     ! Hz, as the settings say
        real(dp) :: at_low, at_high, b2(3)

        associate (dt => ACCELEROMETER_INTERVAL)
            at_low = (2*sin(PI*LOW_FREQUENCY*dt))**2
            ! The mean of 4 sin^2(pi f dt) over the band
            at_high = 2 - (sin(TWO_PI*HIGH_BAND(2)*dt) - sin(TWO_PI*HIGH_BAND(1)*dt))/(PI*dt*(HIGH_BAND(2) - HIGH_BAND(1)))
            b2 = max(0.0_dp, (high**2 - low**2)/(at_high - at_low))
            steep = sqrt(b2/(2*dt))
            white = sqrt(max(0.0_dp, low**2 - b2*at_low)/(2*dt))
        end associate
    end subroutine noise_sigmas

    !> Samples that are missing, and those that are wrong and flagged.
    subroutine choose_wrong(truth, tags, missing, flagged)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: tags(:)
        logical, allocatable, intent(out) :: missing(:), flagged(:)

        type(random_stream_t) :: stream
        real(dp) :: start
        integer :: i, k, place

        stream = truth%stream(WRONG)
        allocate (missing(size(tags)), flagged(size(tags)), source=.false.)
        associate (spans => truth%dynamics%spans, settings => truth%settings)
            do i = 1, size(spans)
                do k = 1, settings%flagged
                    place = nint((spans(i)%start + spans(i)%duration*stream%uniform() - tags(1))/ACCELEROMETER_INTERVAL) + 1
                    flagged(max(1, min(size(tags), place))) = .true.
                end do
                if (i > settings%gaps) cycle
                start = spans(i)%start + (spans(i)%duration - settings%gap)*stream%uniform()
                missing = missing .or. (tags >= start .and. tags < start + settings%gap)
            end do
        end associate
    end subroutine choose_wrong

    !> MAG1A and MAG1B: field and currents. The field is new every second, the currents twice. MAG1A of GRACE is in the
    !> magnetometer's own frame: not written.
    subroutine write_currents(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        real(dp), parameter :: CALIBRATION(2) = [120.0_dp, -137.49_dp]      ! torque_cal of GRACE, GRACE-FO
        real(dp), parameter :: CHANNELS(3) = [0.0_dp, 65000.0_dp, -65000.0_dp]
        real(dp), allocatable :: field(:, :), current(:, :)
        real(dp) :: tag, sign_b, ends(2)
        integer :: n, k, product

        n = 2*(truth%duration - 1)
        allocate (field(3, n), current(3, n))
        call measure_field(truth, field)
        do k = 1, n
            current(:, k) = in_quanta(truth%settings%current_quantum, &
                                      truth%tagged_current(truth%gps_of_obc((k - 1)*HOLD + FIRST_TAG)))
        end do
        if (truth%settings%fault == 'rod-sign') current(2, :) = -current(2, :)
        sign_b = merge(-1, 1, folder%grace_fo .neqv. truth%settings%fault == 'b-sign')
        do product = merge(1, 2, folder%grace_fo), 2
            ends = [0, n - 1]*HOLD + FIRST_TAG
            if (product == 2) ends = truth%gps_of_obc(ends)
            call folder%begin(merge('MAG1A', 'MAG1B', product == 1), n, ends(1), ends(2))
            do k = 1, n
                tag = (k - 1)*HOLD + FIRST_TAG
                if (product == 2) tag = truth%gps_of_obc(tag)
                call folder%tag(tag)
                call folder%put('MfvX_RAW', field(:, k)/MICROTESLA)
                call folder%put('torque1A', max(0.0_dp, current(:, k)))
                call folder%put('torque1B', sign_b*max(0.0_dp, -current(:, k)))
                call folder%put('MF_BCalX', CHANNELS)
                call folder%put('torque_cal', [CALIBRATION(merge(2, 1, folder%grace_fo))])
                call folder%record()
            end do
            call folder%finish()
        end do
    end subroutine write_currents

    !> Samples of the magnetometer, T: the field with its bias and what the rods add, noise, and a time without new values.
    subroutine measure_field(truth, field)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(out) :: field(:, :)        !! (3, two a second)

        type(random_stream_t) :: stream
        type(truth_point_t) :: point
        real(dp) :: time, noise(3)
        integer :: k

        stream = truth%stream(NOISE_MAGNETOMETER)
        associate (settings => truth%settings)
            do k = 1, size(field, 2), 2
                time = truth%gps_of_obc((k - 1)*HOLD + FIRST_TAG)
                call truth%at(time, point)
                call stream%normals(noise)
                field(:, k) = point%acting%field + settings%magnetometer_noise*noise + &
                              NANOTESLA*(settings%magnetometer_bias*MAGNETOMETER_BIAS(:, index('ABCD', truth%satellite)) + &
                                         settings%magnetometer_leakage*matmul(ROD_FIELD, point%current))
                if (k > 2 .and. time > settings%stuck(1) .and. time < sum(settings%stuck)) field(:, k) = field(:, k - 1)
                field(:, k + 1) = field(:, k)
            end do
        end associate
    end subroutine measure_field

    !> A quaternion as the files have it, scalar first.
    subroutine put_attitude(folder, quaternion)
        type(level1_folder_t), intent(inout) :: folder
        real(dp), intent(in) :: quaternion(4)   !! Scalar last

        call folder%put('quatangle', [quaternion(4), quaternion(1:3)])
    end subroutine put_attitude

    !> The true attitude at a time, inertial to body, scalar last.
    pure function attitude_at(truth, time) result(quaternion)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: time            !! GPS, s
        real(dp) :: quaternion(4)

        real(dp) :: state(STATE_SIZE)

        state = truth%arc%state_at(time)
        quaternion = state(ATTITUDE)
    end function attitude_at

    !> An attitude turned by small random angles.
    function shaken(quaternion, stream, sigma) result(turned)
        real(dp), intent(in) :: quaternion(4)
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(in) :: sigma(3)        !! rad
        real(dp) :: turned(4)

        real(dp) :: normal(3)

        call stream%normals(normal)
        turned = quaternion_product(normalised([sigma*normal/2, 1.0_dp]), quaternion)
    end function shaken

    !> SCA1B: the attitude at whole GPS seconds.
    subroutine write_attitude(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        integer, parameter :: HEADS_USED(2) = [4, 23]   ! Both of GRACE; three and the gyros of GRACE-FO
        real(dp), parameter :: QUALITY = 8.77e-7_dp     ! qual_rss, rad: nothing reads it
        type(random_stream_t) :: stream
        integer :: k

        call folder%begin('SCA1B', truth%duration, 0.0_dp, real(truth%duration - 1, dp))
        stream = truth%stream(NOISE_ATTITUDE)
        do k = 0, truth%duration - 1
            call folder%tag(real(k, dp))
            call folder%put('sca_id', [real(HEADS_USED(merge(2, 1, folder%grace_fo)), dp)])
            call put_attitude(folder, shaken(attitude_at(truth, real(k, dp)), stream, spread(truth%settings%attitude_noise, 1, 3)))
            call folder%put('qual_rss', [QUALITY])
            call folder%record()
        end do
        call folder%finish()
    end subroutine write_attitude

    !> QSA1B, how the heads are mounted, and SCA1A, what each of them sees; tags of GRACE's SCA1A are whole seconds.
    subroutine write_heads(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        integer, parameter :: VALID_MODE = int(b'11000001'), VALID = int(b'11000000')
        real(dp), parameter :: DAY = 86400              ! s: calibrations are older than the data
        type(random_stream_t) :: stream
        real(dp) :: mounting(4, HEADS), attitude(4), first, time
        integer :: head, most, k, n, step

        most = merge(HEADS, 2, folder%grace_fo)
        call folder%begin('QSA1B', most, -DAY, -DAY)
        do head = 1, most
            mounting(:, head) = mounting_of(merge(BORESIGHTS(:, head), BORESIGHTS_OF_GRACE(:, min(head, 2)), folder%grace_fo))
            call folder%tag(-DAY)
            call folder%put('sca_id', [real(head, dp)])
            call put_attitude(folder, mounting(:, head))
            call folder%record()
        end do
        call folder%finish()
        n = 2*(truth%duration - 1)
        step = merge(1, 2, folder%grace_fo)
        first = merge(HEAD_TAG, 0.0_dp, folder%grace_fo)
        call folder%begin('SCA1A', n/step*most, first, (n - step)*HOLD + first)
        stream = truth%stream(NOISE_HEADS)
        do k = 0, n - 1, step
            time = k*HOLD + first
            attitude = attitude_at(truth, truth%gps_of_obc(time))
            do head = 1, most
                call folder%tag(time)
                call folder%put('sca_id', [real(head, dp)])
                call folder%put('sca_desig', [real(iachar(merge('P', 'S', head == 1 .or. folder%grace_fo)), dp)])
                call put_attitude(folder, shaken(quaternion_product(conjugate_quaternion(mounting(:, head)), attitude), &
                                                 stream, truth%settings%head_noise))
                call folder%put('nlocks', [0.0_dp, 45.0_dp, 1.0_dp])
                call folder%put('sca_mode', [real(VALID_MODE, dp), real(VALID, dp)])
                call folder%record()
            end do
        end do
        call folder%finish()
    end subroutine write_heads

    !> Head to SRF: z along the boresight, x across it and body z.
    pure function mounting_of(boresight) result(q)
        real(dp), intent(in) :: boresight(3)    !! Any length
        real(dp) :: q(4)

        real(dp) :: axes(3, 3)

        axes(:, 3) = unit(boresight)
        axes(:, 1) = unit(cross([0.0_dp, 0.0_dp, 1.0_dp], axes(:, 3)))
        axes(:, 2) = cross(axes(:, 3), axes(:, 1))
        q = quaternion_of_matrix(axes)      ! columns: the head's axes in SRF
    end function mounting_of

    !> IMU1A: angles of three gyros, eight times a second: sums of the small turns from reading to reading.
    subroutine write_gyros(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        type(random_stream_t) :: stream
        real(dp) :: angle(GYROS), before(4, GYROS), attitude(4), turn(4), time
        integer :: n, k, gyro

        n = nint((truth%duration - 1)/GYRO_INTERVAL)
        call folder%begin('IMU1A', n*GYROS, GYRO_TAG, (n - 1)*GYRO_INTERVAL + GYRO_TAG + (GYROS - 1)*GYRO_STEP)
        stream = truth%stream(NOISE_GYROS)
        angle = 0
        before = spread(attitude_at(truth, 0.0_dp), 2, GYROS)
        do k = 0, n - 1
            do gyro = 1, GYROS
                call folder%tag(k*GYRO_INTERVAL + GYRO_TAG + (gyro - 1)*GYRO_STEP, time)
                time = truth%gps_of_obc(time)
                attitude = attitude_at(truth, time)
                turn = quaternion_product(attitude, conjugate_quaternion(before(:, gyro)))
                before(:, gyro) = attitude
                angle(gyro) = angle(gyro) + dot_product(GYRO_AXES(:, gyro), 2*sign(1.0_dp, turn(4))*turn(1:3))
                call folder%put('gyro_id', [real(gyro, dp), (angle(gyro) + truth%errors%gyro_bias(gyro)*time + &
                                                             truth%settings%gyro_noise*stream%normal())/DEGREE])
                call folder%record()
            end do
        end do
        call folder%finish()
    end subroutine write_gyros

    !> GNV1B and, of GRACE-FO, GNI1B: the orbit at whole GPS seconds, Earth-fixed and inertial.
    subroutine write_orbit(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        !> No formal errors in GNI1B; those of GNV1B, m and m/s
        real(dp), parameter :: NONE(3) = 1e33_dp, FORMAL(3) = [0.0006_dp, 0.0007_dp, 0.001_dp], &
            FORMAL_VELOCITY(3) = [1e-6_dp, 2e-6_dp, 2e-6_dp]
        integer, parameter :: NO_ERRORS = int(b'10000000')
        real(dp) :: state(STATE_SIZE), earth(3, 3), r(3), v(3)
        integer :: k, product

        do product = 1, merge(2, 1, folder%grace_fo)
            call folder%begin(merge('GNV1B', 'GNI1B', product == 1), truth%duration, 0.0_dp, real(truth%duration - 1, dp))
            do k = 0, truth%duration - 1
                state = truth%arc%state_at(real(k, dp))
                r = state(POSITION)
                v = state(VELOCITY)
                call folder%tag(real(k, dp))
                if (product == 1) then
                    earth = truth%dynamics%earth%from_inertial(real(k, dp))
                    r = matmul(earth, r)
                    v = matmul(earth, v) - cross([0.0_dp, 0.0_dp, EARTH_ROTATION_RATE], r)
                    call folder%put('coord_ref', [real(iachar('E'), dp), r, FORMAL, v, FORMAL_VELOCITY, 0.0_dp])
                else
                    call folder%put('coord_ref', [real(iachar('I'), dp), r, NONE, v, NONE, real(NO_ERRORS, dp)])
                end if
                call folder%record()
            end do
            call folder%finish()
        end do
    end subroutine write_orbit

    !> CLK1B, of which the first epoch stands twice, and TIM1B, where receiver and on-board computer differ by their
    !> least step at most.
    subroutine write_clocks(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        integer, parameter :: EVERY = 10, EVERY_TIM = 8     ! s
        integer, parameter :: BEFORE = 2, SYNC = 4          ! Flags
        real(dp), parameter :: STEP_TIM = 119               ! ns
        real(dp), parameter :: CLOCK_ERROR = 1.6e-11_dp, DRIFT_ERROR = 1.7e-12_dp   ! formal, s and s/s
        integer :: k, n

        n = truth%duration/EVERY + 3
        call folder%begin('CLK1B', n + 1, -real(EVERY, dp), real((n - 2)*EVERY, dp))
        do k = -2, n - 2
            call folder%tag(real(max(k, -1)*EVERY, dp))
            call folder%put('clock_id', [-1.0_dp, truth%clock_offset + truth%clock_drift*(max(k, -1)*EVERY), CLOCK_ERROR, &
                                         truth%clock_drift, DRIFT_ERROR, 0.0_dp])
            call folder%put('qualflg', [real(merge(BEFORE, 0, k == -2), dp)])
            call folder%record()
        end do
        call folder%finish()
        n = truth%duration/EVERY_TIM + 3
        call folder%begin('TIM1B', n, -real(EVERY_TIM, dp), real((n - 2)*EVERY_TIM, dp))
        do k = -1, n - 2
            call folder%tag(real(k*EVERY_TIM, dp))
            call folder%put('rcvtime_intg', [real(folder%epoch + k*EVERY_TIM, dp), &
                                             merge(STEP_TIM, 0.0_dp, folder%grace_fo .and. modulo(k, 2) == 1), &
                                             -1.0_dp, -1.0_dp, real(SYNC, dp)])
            call folder%record()
        end do
        call folder%finish()
    end subroutine write_clocks

    !> THR1A and THR1B: a record each firing.
    subroutine write_thrusters(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        integer, parameter :: NOZZLES = 14, BRANCHES = 12   ! Flag 00001100: both branches
        real(dp), parameter :: ON_TIME = 50                 ! ms: FIRING_TIME of day_dynamics
        real(dp), parameter :: COUNTED_BEFORE = 100000      ! firings of each nozzle, of any number
        real(dp) :: counts(NOZZLES), on_time_of(NOZZLES), total(NOZZLES), ends(2)
        real(dp), allocatable :: times(:)
        integer :: i, product

        associate (firings => truth%dynamics%firings)
            ends = 0
            do product = 1, 2
                times = firings%time
                if (product == 1) times = truth%obc_of_gps(times)
                if (size(times) > 0) ends = times([1, size(times)])
                call folder%begin(merge('THR1A', 'THR1B', product == 1), size(firings), ends(1), ends(2))
                counts = COUNTED_BEFORE
                total = 0
                do i = 1, size(firings)
                    on_time_of = 0
                    on_time_of(PAIRS(:, firings(i)%pair)) = ON_TIME
                    counts = counts + merge(1, 0, on_time_of > 0)
                    total = total + on_time_of
                    call folder%tag(times(i))
                    call folder%put('thrust_count_1', counts)
                    call folder%put('on_time_1', on_time_of)
                    call folder%put('accum_dur_1', total)
                    call folder%put('qualflg', [real(merge(BRANCHES, 0, folder%grace_fo), dp)])
                    call folder%record()
                end do
                call folder%finish()
            end do
        end associate
    end subroutine write_thrusters

    !> MAS1B, the gas in both tanks, of which the firings take the same from each, and TNK1B, their state.
    subroutine write_tanks(truth, folder)
        type(level1_truth_t), intent(in) :: truth
        type(level1_folder_t), intent(inout) :: folder

        real(dp), parameter :: EVERY = 60                   ! s; real files have an hour, which short spans would lack
        real(dp), parameter :: GAS(2) = [13.4351_dp, 13.4565_dp]        ! kg
        real(dp), parameter :: USED = 0.7e-6_dp             ! kg of a tank by a firing: two of 10 mN for 50 ms at 70 s
        integer, parameter :: GAS_FLAG = int(b'11000000'), STATES = 7
        real(dp), parameter :: TANK(STATES) = [150.0_dp, 1.5_dp, 18.0_dp, 18.1_dp, 17.9_dp, 18.2_dp, 18.3_dp]
        ! bar, deg C: of some size; nothing reads them
        integer, parameter :: TANK_FLAGS(2) = [31, 127]     ! GRACE, GRACE-FO
        integer :: k, n, number

        n = int(truth%duration/EVERY) + 1
        call folder%begin('MAS1B', n, 0.0_dp, (n - 1)*EVERY)
        do k = 0, n - 1
            call folder%tag(k*EVERY)
            call folder%put('prod_flag', [real(GAS_FLAG, dp)])
            call folder%put('gas_mass_tnk1', GAS - USED*count(truth%dynamics%firings%time < k*EVERY))
            call folder%record()
        end do
        call folder%finish()
        call folder%begin('TNK1B', 2*n, 0.0_dp, (n - 1)*EVERY)
        do k = 0, n - 1
            do number = 1, 2
                call folder%tag(k*EVERY)
                call folder%put('tank_id', [real(number, dp)])
                call folder%put('prod_flag', [real(TANK_FLAGS(merge(2, 1, folder%grace_fo)), dp)])
                call folder%put('tank_pres', TANK)
                call folder%record()
            end do
        end do
        call folder%finish()
    end subroutine write_tanks
end module gracecg_level1_simulated_files
