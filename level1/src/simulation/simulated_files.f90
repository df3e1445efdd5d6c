!> A simulated folder of Level-1 files: what GRACE or GRACE-FO would have delivered of a flight, with the errors of clocks
!> and instruments.
!>
!>     call new_level1_orbit(case, settings, orbit, error)         ! once
!>     call new_level1_truth(orbit, seed, run, truth, error)       ! each run
!>     call write_level1_folder(truth, seed, run, 'day', .false., written, error)
!>
!> Tags of 1A files are those of the on-board computer; times of the truth are GPS. Text is that of GRACE-FO (C, D) or
!> GRACE (A, B); binary that of GRACE, but for what has no binary form (IMU1A, and SCA1A of GRACE-FO), which stays text.
module gracecg_level1_simulated_files
    use, intrinsic :: iso_fortran_env, only: real32
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: DEGREE, EARTH_ROTATION_RATE, MICROTESLA, MILLIMETRE, NANOTESLA, TWO_PI
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion, quaternion_of_matrix, quaternion_from_axis_angle, &
        normalised
    use gracecg_base_random, only: random_stream_t
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_base_vectors, only: cross, unit
    use gracecg_files_csv, only: csv_writer_t, SIDE_ENDING
    use gracecg_files_file, only: output_file_t, remove_file
    use gracecg_files_settings, only: settings_t, FULL_RANGE
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_products, only: level1_layout_t, level1_layout, satellite_of_grace_fo, KIND_F4
    use gracecg_level1_setup, only: level1_setup_t, describe_level1
    use gracecg_level1_time, only: gps_date_text
    use gracecg_level1_writer, only: level1_writer_t
    use gracecg_level1_simulation_settings, only: describe_level1_simulation, by_satellite
    use gracecg_level1_simulated_truth, only: level1_truth_t, truth_point_t, level1_stream, PAIRS
    implicit none
    private
    public :: level1_errors_t, draw_errors, write_level1_folder
    public :: ACCELEROMETER_INTERVAL, ROD_FIELD, MAGNETOMETER_BIAS, GYRO_AXES, BORESIGHTS, TRUTH_NAMELIST, SETUP_NAME

    character(*), parameter :: TRUTH_TABLE = 'truth.csv', SOE_NAME = 'SOE.txt'
    character(*), parameter :: TRUTH_NAMELIST = 'truth.nml'     !! Name of the file with what is true and no estimator reads
    character(*), parameter :: SETUP_NAME = 'setup.nml'         !! Name of the file with what the operator says

    real(dp), parameter :: ACCELEROMETER_INTERVAL = 0.0999910_dp    !! Of ACC1A, s: GRACE-FO C, 2023-06-01
    real(dp), parameter :: FIRST_SAMPLE = 0.007739_dp   !! s
    real(dp), parameter :: TAG = 0.1_dp, HALF = 0.5_dp  !! Of MAG and THR in a second of the on-board computer, s
    real(dp), parameter :: HEAD_TAG = 0.03_dp           !! Of SCA1A, s
    real(dp), parameter :: GYRO_INTERVAL = 0.125_dp, GYRO_TAG = 0.004_dp, GYRO_STEP = 0.001126_dp   !! Of IMU1A, s
    integer, parameter :: HEADS = 3, GYROS = 3

    !> What the rods add to the magnetometer, nT/mA, axis and rod: GRACE-A
    real(dp), parameter :: ROD_FIELD(3, 3) = reshape([3.1_dp, -37.7_dp, 37.3_dp, -3.0_dp, -5.1_dp, -1.4_dp, &
                                                      -23.2_dp, -1.0_dp, 2.4_dp], [3, 3])
    !> Biases of the magnetometers of A to D, nT; B is taken as A
    real(dp), parameter :: MAGNETOMETER_BIAS(3, 4) = reshape([ &
        267.0_dp, -2615.0_dp, -2722.0_dp, 267.0_dp, -2615.0_dp, -2722.0_dp, -530.0_dp, 16.0_dp, 250.0_dp, &
        1132.0_dp, 157.0_dp, -431.0_dp], [3, 4])
    !> Boresights of the star cameras' heads of GRACE-FO in SRF
    real(dp), parameter :: BORESIGHTS(3, HEADS) = reshape([0.508_dp, 0.0_dp, -0.861_dp, -0.460_dp, 0.763_dp, -0.454_dp, &
                                                           -0.444_dp, -0.769_dp, -0.459_dp], [3, HEADS])
    real(dp), parameter :: BORESIGHT_ELEVATION = 45*DEGREE      !! Of the heads of GRACE, above the body's x-y plane, to both sides
    !> Axes of the gyros: three of a tetrahedron, of which one does not see the orbital rate
    real(dp), parameter :: GYRO_AXES(3, GYROS) = reshape([ &
        0.5773502691896258_dp, 0.816496580927726_dp, 0.0_dp, -0.5773502691896258_dp, 0.0_dp, 0.816496580927726_dp, &
        0.5773502691896258_dp, -0.816496580927726_dp, 0.0_dp], [3, GYROS])

    integer, parameter :: NOISE_ACCELEROMETER = 11, NOISE_MAGNETOMETER = 12, NOISE_ATTITUDE = 13, NOISE_HEADS = 14, &
        NOISE_GYROS = 15, ERRORS = 16, WRONG = 17   ! Streams of random numbers

    type :: level1_errors_t
        !! What is drawn of the instruments of a run
        real(dp) :: scale(3) = 1            !! Of the accelerometer
        real(dp) :: angular_scale(3) = 1    !! Of its angular channels
        real(dp) :: leak(3, 3) = 0          !! L: axis, rod; m/s^2/mA
        real(dp) :: leak_rate(3, 3) = 0     !! K, m/s^2/(mA/s)
        real(dp) :: angular_leak(3, 3) = 0  !! La, rad/s^2/mA
        real(dp) :: angular_leak_rate(3, 3) = 0     !! Ka, rad/s^2/(mA/s)
        real(dp) :: gyro_bias(GYROS) = 0    !! rad/s
        real(dp) :: inertia_factor = 1      !! What is said of the inertia, by the true one
    end type level1_errors_t

    type :: product_file_t
        !! A file of one product being written
        type(level1_writer_t) :: writer
        type(level1_layout_t) :: layout
        real(dp), allocatable :: values(:)  !! By field
        character(:), allocatable :: path
    end type product_file_t

    type :: folder_t
        !! What all files of the folder share
        character(:), allocatable :: name
        character(1) :: satellite = ''
        logical :: grace_fo = .true.
        logical :: binary = .false.
        integer(i8) :: epoch = 0            !! GPS s past 2000-01-01 12:00
        type(string_t), allocatable :: written(:)   !! Names, in their order
    end type folder_t

contains

    !> Draws what instruments of a run have wrong.
    function draw_errors(truth, seed, run) result(errors_drawn)
        type(level1_truth_t), intent(in) :: truth
        integer(i8), intent(in) :: seed     !! Of the random numbers
        integer, intent(in) :: run          !! Names them, too
        type(level1_errors_t) :: errors_drawn

        type(random_stream_t) :: stream
        integer :: axis, rod

        stream = level1_stream(truth%orbit, seed, run, ERRORS)
        associate (settings => truth%orbit%settings, e => errors_drawn)
            do axis = 1, 3
                call draw(1.0_dp, settings%scale_error, e%scale(axis))
                call draw(1.0_dp, settings%angular_scale_error, e%angular_scale(axis))
                call draw(0.0_dp, settings%gyro_bias, e%gyro_bias(axis))
                do rod = 1, 3
                    call draw(0.0_dp, settings%leakage(1), e%leak(axis, rod))
                    call draw(0.0_dp, settings%leakage(2), e%leak_rate(axis, rod))
                    call draw(0.0_dp, settings%angular_leakage(1), e%angular_leak(axis, rod))
                    call draw(0.0_dp, settings%angular_leakage(2), e%angular_leak_rate(axis, rod))
                end do
            end do
            call draw(1.0_dp, settings%inertia_error, e%inertia_factor)
        end associate

    contains

        subroutine draw(mean, sigma, value)
            real(dp), intent(in) :: mean, sigma
            real(dp), intent(out) :: value

            value = stream%normal()
            value = mean + sigma*value
        end subroutine draw
    end function draw_errors

    !> Writes all files of a run into a folder that is there. After a failure none of them is left.
    subroutine write_level1_folder(truth, seed, run, name, binary, written, error)
        type(level1_truth_t), intent(in) :: truth
        integer(i8), intent(in) :: seed             !! Of the random numbers
        integer, intent(in) :: run                  !! Names them, too
        character(*), intent(in) :: name            !! Of the folder
        logical, intent(in) :: binary               !! GRACE's binary records, where there are such
        type(string_t), allocatable, intent(out) :: written(:)  !! Names of the files
        type(error_t), allocatable, intent(out) :: error

        type(folder_t) :: folder
        type(level1_errors_t) :: drawn
        integer :: i

        folder%name = trim(name)
        folder%satellite = truth%orbit%satellite
        folder%grace_fo = satellite_of_grace_fo(folder%satellite)
        folder%binary = binary
        folder%epoch = truth%orbit%epoch
        allocate (folder%written(0))
        drawn = draw_errors(truth, seed, run)
        call write_accelerometer(truth, drawn, seed, run, folder, error)
        if (.not. allocated(error)) call write_currents(truth, seed, run, folder, error)
        if (.not. allocated(error)) call write_attitude(truth, seed, run, folder, error)
        if (.not. allocated(error)) call write_heads(truth, seed, run, folder, error)
        if (.not. allocated(error) .and. folder%grace_fo) call write_gyros(truth, drawn, seed, run, folder, error)
        if (.not. allocated(error)) call write_orbit(truth, folder, error)
        if (.not. allocated(error)) call write_clocks(truth, folder, error)
        if (.not. allocated(error)) call write_thrusters(truth, folder, error)
        if (.not. allocated(error)) call write_tanks(truth, folder, error)
        if (.not. allocated(error)) call write_events(truth, folder, error)
        if (.not. allocated(error)) call write_setup(truth, drawn, folder, error)
        if (.not. allocated(error)) call write_truth_files(truth, drawn, seed, run, folder, error)
        if (.not. allocated(error)) then
            call move_alloc(folder%written, written)
            return
        end if
        do i = 1, size(folder%written)
            call remove_file(folder%name//'/'//folder%written(i)%text)
        end do
        call add_context(error, 'simulated Level-1 files')
        allocate (written(0))
    end subroutine write_level1_folder

    !> Begins the file of a product.
    subroutine begin(folder, product, records, first, last, file, error)
        type(folder_t), intent(inout) :: folder
        character(5), intent(in) :: product
        integer, intent(in) :: records
        real(dp), intent(in) :: first, last     !! Tags, s from the beginning
        type(product_file_t), intent(inout) :: file
        type(error_t), allocatable, intent(out) :: error

        type(level1_header_t) :: header
        character(26) :: date
        character(:), allocatable :: name
        character(4) :: ending
        logical :: binary

        call level1_layout(product, folder%grace_fo, file%layout, error)
        if (allocated(error)) return
        binary = folder%binary .and. file%layout%has_binary
        ending = '.txt'
        if (.not. folder%grace_fo) ending = '.asc'
        if (binary) ending = '.dat'
        header%satellite = folder%satellite
        header%records = records
        header%first_time = real(folder%epoch, dp) + first
        header%last_time = real(folder%epoch, dp) + last
        date = gps_date_text(folder%epoch, 0.0_dp)
        name = product//'_'//date(:10)//'_'//folder%satellite//'_'//merge('04', '02', folder%grace_fo)//ending
        file%path = folder%name//'/'//name
        if (allocated(file%values)) deallocate (file%values)
        allocate (file%values(size(file%layout%fields)), source=0.0_dp)
        if (file%layout%id > 0) file%values(file%layout%id) = iachar(folder%satellite)
        if (file%layout%time_ref > 0) file%values(file%layout%time_ref) = iachar(merge('R', 'G', product(5:5) == 'A'))
        call file%writer%open(file%path, file%layout, binary, header, error)
        if (allocated(error)) return
        call append(folder%written, name)
    end subroutine begin

    !> Puts values in a row of fields, the first by its name. Of single precision is what binary has so.
    subroutine put(file, name, values)
        type(product_file_t), intent(inout) :: file
        character(*), intent(in) :: name
        real(dp), intent(in) :: values(:)

        integer :: first, i

        first = file%layout%field_of(name) - 1
        do i = 1, size(values)
            file%values(first + i) = values(i)
            if (file%layout%fields(first + i)%kind == KIND_F4) file%values(first + i) = real(real(values(i), real32), dp)
        end do
    end subroutine put

    !> A time tag, s from the beginning, as seconds and microseconds; and as it is then.
    subroutine put_tag(file, folder, time, rounded)
        type(product_file_t), intent(inout) :: file
        type(folder_t), intent(in) :: folder
        real(dp), intent(in) :: time
        real(dp), intent(out), optional :: rounded      !! s from the beginning

        integer(i8) :: ticks

        ticks = nint(time*1e6_dp, i8)
        file%values(1) = real(folder%epoch + floor(real(ticks, dp)/1e6_dp, i8), dp)
        if (file%layout%fraction > 0) file%values(file%layout%fraction) = real(modulo(ticks, 1000000_i8), dp)
        if (present(rounded)) rounded = real(ticks, dp)/1e6_dp
    end subroutine put_tag

    !> The accelerometer: linear and angular accelerations through scale, bias, leakage, noise and quanta. Noise of the
    !> linear axes is white with differences of white noise, whose one-sided density is
    !>
    !>     S(f) = a^2 + b^2 (2 sin(pi f dt))^2
    !>
    !> with the densities at 0.1 Hz and, as a mean, from 2 to 5 Hz that the settings have.
    subroutine write_accelerometer(truth, drawn, seed, run, folder, error)
        type(level1_truth_t), intent(in) :: truth
        type(level1_errors_t), intent(in) :: drawn
        integer(i8), intent(in) :: seed
        integer, intent(in) :: run
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: FACTORS(4) = [1, 1, 1, 6]    ! Of noise: A to D
        integer, parameter :: PRODUCTS = int(b'00000100000000000000000000111111')   ! Accelerations and block number
        integer, parameter :: NO_MAPPING = int(b'01000000'), BLOCKS = 65536
        real(dp), parameter :: WRONG_BY = 1e-6_dp           ! m/s^2, of flagged samples
        real(dp), parameter :: EARLIER = 30                 ! s: transplanted data are those of another place
        type(product_file_t) :: file
        type(random_stream_t) :: stream, wrong_stream
        type(truth_point_t) :: point, other
        real(dp), allocatable :: tags(:)
        logical, allocatable :: missing(:), flagged(:)
        real(dp) :: white(3), steep(3), before(3), now(3), linear(3), angular(3), time, factor, angular_sigma(3)
        integer :: n, k, axis

        associate (settings => truth%orbit%settings)
            n = floor((truth%orbit%duration - 1)/ACCELEROMETER_INTERVAL)
            tags = [(FIRST_SAMPLE + k*ACCELEROMETER_INTERVAL, k=0, n - 1)]
            wrong_stream = level1_stream(truth%orbit, seed, run, WRONG)
            call choose_wrong(truth, wrong_stream, tags, missing, flagged)
            factor = settings%noise_factor
            if (factor < 0) factor = by_satellite(folder%satellite, FACTORS)
            call noise_sigmas(factor*settings%noise_low, factor*settings%noise_high, white, steep)
            angular_sigma = factor*settings%angular_noise/sqrt(2*ACCELEROMETER_INTERVAL)
            call begin(folder, 'ACC1A', count(.not. missing), tags(1), tags(n), file, error)
            if (allocated(error)) return
            if (settings%fault == 'obc-tags') file%values(file%layout%time_ref) = iachar('G')
            file%values(file%layout%prod_flag) = PRODUCTS
            stream = level1_stream(truth%orbit, seed, run, NOISE_ACCELEROMETER)
            before = 0
            do k = 1, n
                call put_tag(file, folder, tags(k), time)
                time = truth%gps_of_obc(time) - settings%accelerometer_delay
                call truth%at(time, point)
                do axis = 1, 3
                    now(axis) = steep(axis)*stream%normal()
                    linear(axis) = white(axis)*stream%normal() + now(axis) - before(axis)
                    angular(axis) = angular_sigma(axis)*stream%normal()
                end do
                before = now
                linear = linear + settings%bias + drawn%scale*point%sensed + matmul(drawn%leak, point%current) + &
                    matmul(drawn%leak_rate, point%current_rate)
                angular = angular + settings%angular_bias + drawn%angular_scale*point%acceleration + &
                    matmul(drawn%angular_leak, point%current) + matmul(drawn%angular_leak_rate, point%current_rate)
                where (settings%angular_quantum > 0) angular = settings%angular_quantum* &
                    anint(angular/max(settings%angular_quantum, tiny(angular)))
                if (settings%fault == 'transplanted') then
                    call truth%at(time - min(time, EARLIER), other)
                    linear(1:2) = settings%bias(1:2) - other%sensed(1:2)
                    angular = 0
                end if
                if (missing(k)) cycle
                file%values(file%layout%qualflg) = merge(NO_MAPPING, 0, flagged(k))
                if (flagged(k)) linear = linear + WRONG_BY
                if (settings%fault == 'srf-as-af') then
                    call put(file, 'lin_accl_x', [linear, angular])
                else        ! x, y, z of AF are y, z, x of SRF
                    call put(file, 'lin_accl_x', [linear(2), linear(3), linear(1), angular(2), angular(3), angular(1)])
                end if
                call put(file, 'icu_blk_nr', [real(modulo(k - 1, BLOCKS), dp)])
                call file%writer%record(file%values)
            end do
        end associate
        call file%writer%commit(error)
    end subroutine write_accelerometer

    !> Standard deviations of the white noise and of that whose differences are taken, by sample.
    pure subroutine noise_sigmas(low, high, white, steep)
        real(dp), intent(in) :: low(3), high(3)         !! m/s^2/sqrt(Hz), one-sided
        real(dp), intent(out) :: white(3), steep(3)     !! m/s^2

        real(dp), parameter :: LOW_FREQUENCY = 0.1_dp, HIGH_BAND(2) = [2.0_dp, 5.0_dp]     ! Hz
        real(dp) :: at_low, at_high, b2(3)

        associate (dt => ACCELEROMETER_INTERVAL)
            at_low = (2*sin(TWO_PI/2*LOW_FREQUENCY*dt))**2
            ! The mean of 4 sin^2(pi f dt) over the band
            at_high = 2 - (sin(TWO_PI*HIGH_BAND(2)*dt) - sin(TWO_PI*HIGH_BAND(1)*dt))/ &
                (TWO_PI/2*dt*(HIGH_BAND(2) - HIGH_BAND(1)))
            b2 = max(0.0_dp, (high**2 - low**2)/(at_high - at_low))
            steep = sqrt(b2/(2*dt))
            white = sqrt(max(0.0_dp, low**2 - b2*at_low)/(2*dt))
        end associate
    end subroutine noise_sigmas

    !> Samples that are missing, and those that are wrong and flagged.
    subroutine choose_wrong(truth, stream, tags, missing, flagged)
        type(level1_truth_t), intent(in) :: truth
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(in) :: tags(:)
        logical, allocatable, intent(out) :: missing(:), flagged(:)

        real(dp) :: start
        integer :: i, k, place

        allocate (missing(size(tags)), flagged(size(tags)), source=.false.)
        associate (orbit => truth%orbit)
            do i = 1, size(orbit%spans)
                associate (span => orbit%spans(i), gap => orbit%settings%gap)
                    do k = 1, orbit%settings%flagged
                        place = nint((span%start + span%duration*stream%uniform() - tags(1))/ACCELEROMETER_INTERVAL) + 1
                        flagged(max(1, min(size(tags), place))) = .true.
                    end do
                    if (i > orbit%settings%gaps) cycle
                    start = span%start + (span%duration - gap)*stream%uniform()
                    missing = missing .or. (tags >= start .and. tags < start + gap)
                end associate
            end do
        end associate
    end subroutine choose_wrong

    !> MAG1A and MAG1B: field and currents. The field is new every second, the currents twice.
    subroutine write_currents(truth, seed, run, folder, error)
        type(level1_truth_t), intent(in) :: truth
        integer(i8), intent(in) :: seed
        integer, intent(in) :: run
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: CALIBRATION(2) = [120.0_dp, -137.49_dp]      ! torque_cal of GRACE, GRACE-FO
        real(dp), parameter :: CHANNELS(3) = [0.0_dp, 65000.0_dp, -65000.0_dp]
        type(product_file_t) :: file
        type(random_stream_t) :: stream
        type(truth_point_t) :: point
        real(dp), allocatable :: field(:, :), current(:, :)
        real(dp) :: time, new(3), sign_b
        integer :: n, k, axis, product

        n = 2*(truth%orbit%duration - 1)
        allocate (field(3, n), current(3, n))
        stream = level1_stream(truth%orbit, seed, run, NOISE_MAGNETOMETER)
        associate (settings => truth%orbit%settings)
            do k = 1, n
                time = truth%gps_of_obc((k - 1)*HALF + TAG)
                current(:, k) = truth%tagged_current(time)
                if (settings%current_quantum > 0) current(:, k) = settings%current_quantum* &
                    anint(current(:, k)/settings%current_quantum)
                if (settings%fault == 'rod-sign') current(2, k) = -current(2, k)
                if (modulo(k, 2) == 0) then
                    field(:, k) = field(:, k - 1)
                    cycle
                end if
                call truth%at(time, point)
                do axis = 1, 3
                    new(axis) = settings%magnetometer_noise*stream%normal()
                end do
                field(:, k) = point%field + new + settings%magnetometer_bias*NANOTESLA* &
                    MAGNETOMETER_BIAS(:, index('ABCD', folder%satellite)) + &
                    settings%magnetometer_leakage*NANOTESLA*matmul(ROD_FIELD, point%current)
                if (k > 2 .and. time > settings%stuck(1) .and. time < sum(settings%stuck)) field(:, k) = field(:, k - 1)
            end do
            sign_b = merge(-1, 1, folder%grace_fo)
            if (settings%fault == 'b-sign') sign_b = -sign_b
        end associate
        ! MAG1A of GRACE is in the magnetometer's own frame: not written
        do product = merge(1, 2, folder%grace_fo), 2
            call begin(folder, merge('MAG1A', 'MAG1B', product == 1), n, TAG, (n - 1)*HALF + TAG, file, error)
            if (allocated(error)) return
            do k = 1, n
                time = (k - 1)*HALF + TAG
                if (product == 2) time = truth%gps_of_obc(time)
                call put_tag(file, folder, time)
                call put(file, 'MfvX_RAW', field(:, k)/MICROTESLA)
                call put(file, 'torque1A', max(0.0_dp, current(:, k)))
                call put(file, 'torque1B', sign_b*max(0.0_dp, -current(:, k)))
                call put(file, 'MF_BCalX', CHANNELS)
                call put(file, 'torque_cal', [CALIBRATION(merge(2, 1, folder%grace_fo))])
                call file%writer%record(file%values)
            end do
            call file%writer%commit(error)
            if (allocated(error)) return
        end do
    end subroutine write_currents

    !> A quaternion as the files have it, scalar first.
    subroutine put_attitude(file, quaternion)
        type(product_file_t), intent(inout) :: file
        real(dp), intent(in) :: quaternion(4)   !! Scalar last

        call put(file, 'quatangle', [quaternion(4), quaternion(1:3)])
    end subroutine put_attitude

    !> An attitude turned by small random angles, rad.
    subroutine shake(stream, sigma, quaternion)
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(in) :: sigma(3)
        real(dp), intent(inout) :: quaternion(4)

        real(dp) :: angle(3)
        integer :: i

        do i = 1, 3
            angle(i) = sigma(i)*stream%normal()
        end do
        quaternion = quaternion_product(normalised([angle/2, 1.0_dp]), quaternion)
    end subroutine shake

    !> SCA1B: the attitude at whole GPS seconds.
    subroutine write_attitude(truth, seed, run, folder, error)
        type(level1_truth_t), intent(in) :: truth
        integer(i8), intent(in) :: seed
        integer, intent(in) :: run
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: HEADS_USED(2) = [4, 23]   ! Both of GRACE; three and the gyros of GRACE-FO
        real(dp), parameter :: QUALITY = 8.77e-7_dp     ! qual_rss, rad
        type(product_file_t) :: file
        type(random_stream_t) :: stream
        real(dp) :: rate(3), quaternion(4), angle(3)
        integer :: k

        call begin(folder, 'SCA1B', truth%orbit%duration, 0.0_dp, real(truth%orbit%duration - 1, dp), file, error)
        if (allocated(error)) return
        stream = level1_stream(truth%orbit, seed, run, NOISE_ATTITUDE)
        do k = 0, truth%orbit%duration - 1
            call truth%motion(real(k, dp), rate, quaternion, angle)
            call shake(stream, spread(truth%orbit%settings%attitude_noise, 1, 3), quaternion)
            call put_tag(file, folder, real(k, dp))
            call put(file, 'sca_id', [real(HEADS_USED(merge(2, 1, folder%grace_fo)), dp)])
            call put_attitude(file, quaternion)
            call put(file, 'qual_rss', [QUALITY])
            call file%writer%record(file%values)
        end do
        call file%writer%commit(error)
    end subroutine write_attitude

    !> QSA1B, how the heads are mounted, and SCA1A, what each of them sees.
    subroutine write_heads(truth, seed, run, folder, error)
        type(level1_truth_t), intent(in) :: truth
        integer(i8), intent(in) :: seed
        integer, intent(in) :: run
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: VALID_MODE = int(b'11000001'), VALID = int(b'11000000')
        real(dp), parameter :: DAY = 86400
        type(product_file_t) :: file
        type(random_stream_t) :: stream
        real(dp) :: mounting(4, HEADS), rate(3), quaternion(4), angle(3), time
        integer :: head, most, k, n, first

        most = merge(HEADS, 2, folder%grace_fo)
        call begin(folder, 'QSA1B', most, -DAY, -DAY, file, error)
        if (allocated(error)) return
        do head = 1, most
            mounting(:, head) = mounting_of(boresight(head, folder%grace_fo))
            call put_tag(file, folder, -DAY)
            call put(file, 'sca_id', [real(head, dp)])
            call put_attitude(file, mounting(:, head))
            call file%writer%record(file%values)
        end do
        call file%writer%commit(error)
        if (allocated(error)) return
        n = 2*(truth%orbit%duration - 1)
        first = merge(1, 2, folder%grace_fo)    ! tags of GRACE's SCA1A are whole seconds: a record each second
        call begin(folder, 'SCA1A', n/first*most, HEAD_TAG, (n - first)*HALF + HEAD_TAG, file, error)
        if (allocated(error)) return
        stream = level1_stream(truth%orbit, seed, run, NOISE_HEADS)
        do k = 0, n - 1, first
            time = k*HALF
            if (folder%grace_fo) time = time + HEAD_TAG
            call truth%motion(truth%gps_of_obc(time), rate, quaternion, angle)
            do head = 1, most
                call put_tag(file, folder, time)
                call put(file, 'sca_id', [real(head, dp)])
                call put(file, 'sca_desig', [real(iachar(merge('P', 'S', head == 1 .or. folder%grace_fo)), dp)])
                angle = truth%orbit%settings%head_noise
                call put_attitude(file, head_attitude(stream, angle, mounting(:, head), quaternion))
                call put(file, 'nlocks', [0.0_dp, 45.0_dp, 1.0_dp])
                call put(file, 'sca_mode', [real(VALID_MODE, dp), real(VALID, dp)])
                call file%writer%record(file%values)
            end do
        end do
        call file%writer%commit(error)
    end subroutine write_heads

    !> What a head sees: inertial to head, with its noise.
    function head_attitude(stream, sigma, mounting, quaternion) result(seen)
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(in) :: sigma(3), mounting(4), quaternion(4)
        real(dp) :: seen(4)

        seen = quaternion_product(conjugate_quaternion(mounting), quaternion)
        call shake(stream, sigma, seen)
    end function head_attitude

    pure function boresight(head, grace_fo) result(direction)
        integer, intent(in) :: head
        logical, intent(in) :: grace_fo
        real(dp) :: direction(3)

        direction = [0.0_dp, merge(1, -1, head == 1)*cos(BORESIGHT_ELEVATION), -sin(BORESIGHT_ELEVATION)]
        if (grace_fo) direction = BORESIGHTS(:, head)
    end function boresight

    !> Head to SRF: z along the boresight, x across it and body x, or body y where the boresight is near that.
    pure function mounting_of(direction) result(q)
        real(dp), intent(in) :: direction(3)
        real(dp) :: q(4)

        real(dp) :: axes(3, 3)

        axes(:, 3) = unit(direction)
        axes(:, 1) = unit(cross([0.0_dp, 0.0_dp, 1.0_dp], axes(:, 3)))
        axes(:, 2) = cross(axes(:, 3), axes(:, 1))
        q = quaternion_of_matrix(axes)      ! columns: the head's axes in SRF
    end function mounting_of

    !> IMU1A: angles of three gyros, eight times a second.
    subroutine write_gyros(truth, drawn, seed, run, folder, error)
        type(level1_truth_t), intent(in) :: truth
        type(level1_errors_t), intent(in) :: drawn
        integer(i8), intent(in) :: seed
        integer, intent(in) :: run
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        type(product_file_t) :: file
        type(random_stream_t) :: stream
        real(dp) :: rate(3), quaternion(4), angle(3), first(3), time, tag_time, seen
        integer :: n, k, gyro

        n = nint((truth%orbit%duration - 1)/GYRO_INTERVAL)
        call begin(folder, 'IMU1A', n*GYROS, GYRO_TAG, (n - 1)*GYRO_INTERVAL + GYRO_TAG, file, error)
        if (allocated(error)) return
        stream = level1_stream(truth%orbit, seed, run, NOISE_GYROS)
        call truth%motion(0.0_dp, rate, quaternion, first)
        do k = 0, n - 1
            do gyro = 1, GYROS
                tag_time = k*GYRO_INTERVAL + GYRO_TAG + (gyro - 1)*GYRO_STEP
                call put_tag(file, folder, tag_time, time)
                time = truth%gps_of_obc(time)
                call truth%motion(time, rate, quaternion, angle)
                seen = dot_product(GYRO_AXES(:, gyro), angle - first) + drawn%gyro_bias(gyro)*time + &
                    truth%orbit%settings%gyro_noise*stream%normal()
                call put(file, 'gyro_id', [real(gyro, dp), seen/DEGREE])
                call file%writer%record(file%values)
            end do
        end do
        call file%writer%commit(error)
    end subroutine write_gyros

    !> GNV1B and, of GRACE-FO, GNI1B: the orbit at whole GPS seconds, Earth-fixed and inertial.
    subroutine write_orbit(truth, folder, error)
        type(level1_truth_t), intent(in) :: truth
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: NONE(3) = 1e33_dp, FORMAL(3) = [0.0006_dp, 0.0007_dp, 0.001_dp], &
            FORMAL_VELOCITY(3) = [1e-6_dp, 2e-6_dp, 2e-6_dp]
        integer, parameter :: NO_ERRORS = int(b'10000000')
        type(product_file_t) :: file
        real(dp) :: r(3), v(3)
        integer :: k, product

        associate (orbit => truth%orbit)
            do product = 1, merge(2, 1, folder%grace_fo)
                call begin(folder, merge('GNV1B', 'GNI1B', product == 1), orbit%duration, 0.0_dp, &
                           real(orbit%duration - 1, dp), file, error)
                if (allocated(error)) return
                do k = 0, orbit%duration - 1
                    call put_tag(file, folder, real(k, dp))
                    if (product == 2) then
                        call put(file, 'coord_ref', [real(iachar('I'), dp), orbit%position(:, k), NONE, orbit%velocity(:, k), &
                                                     NONE, real(NO_ERRORS, dp)])
                    else
                        r = matmul(orbit%position(:, k), orbit%earth(:, :, k))
                        v = matmul(orbit%velocity(:, k), orbit%earth(:, :, k)) - &
                            cross([0.0_dp, 0.0_dp, EARTH_ROTATION_RATE], r)
                        call put(file, 'coord_ref', [real(iachar('E'), dp), r, FORMAL, v, FORMAL_VELOCITY, 0.0_dp])
                    end if
                    call file%writer%record(file%values)
                end do
                call file%writer%commit(error)
                if (allocated(error)) return
            end do
        end associate
    end subroutine write_orbit

    !> CLK1B, of which the first epoch stands twice, and TIM1B, where receiver and on-board computer differ by their
    !> least step at most.
    subroutine write_clocks(truth, folder, error)
        type(level1_truth_t), intent(in) :: truth
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: EVERY = 10, EVERY_TIM = 8     ! s
        integer, parameter :: BEFORE = 2, SYNC = 4          ! Flags
        real(dp), parameter :: STEP_TIM = 119               ! ns
        type(product_file_t) :: file
        integer :: k, n

        n = truth%orbit%duration/EVERY + 3
        call begin(folder, 'CLK1B', n + 1, -real(EVERY, dp), real((n - 2)*EVERY, dp), file, error)
        if (allocated(error)) return
        do k = -1, n - 2
            call put_tag(file, folder, real(k*EVERY, dp))
            call put(file, 'clock_id', [-1.0_dp, truth%clock_offset + truth%clock_drift*(k*EVERY), 1.6e-11_dp, &
                                        truth%clock_drift, 1.7e-12_dp, 0.0_dp])
            if (k == -1) then
                file%values(file%layout%qualflg) = BEFORE
                call file%writer%record(file%values)
                file%values(file%layout%qualflg) = 0
            end if
            call file%writer%record(file%values)
        end do
        call file%writer%commit(error)
        if (allocated(error)) return
        n = truth%orbit%duration/EVERY_TIM + 3
        call begin(folder, 'TIM1B', n, -real(EVERY_TIM, dp), real((n - 2)*EVERY_TIM, dp), file, error)
        if (allocated(error)) return
        do k = -1, n - 2
            call put_tag(file, folder, real(k*EVERY_TIM, dp))
            call put(file, 'rcvtime_intg', [file%values(1), merge(STEP_TIM, 0.0_dp, folder%grace_fo .and. modulo(k, 2) == 1), &
                                            -1.0_dp, -1.0_dp, real(SYNC, dp)])
            call file%writer%record(file%values)
        end do
        call file%writer%commit(error)
    end subroutine write_clocks

    !> THR1A and THR1B: a record each firing.
    subroutine write_thrusters(truth, folder, error)
        type(level1_truth_t), intent(in) :: truth
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: NOZZLES = 14, BRANCHES = 12   ! Flag 00001100: both branches
        real(dp), parameter :: ON_TIME = 50                 ! ms
        type(product_file_t) :: file
        real(dp) :: counts(NOZZLES), on_time_of(NOZZLES), total(NOZZLES), time, first, last
        integer :: i, product, n

        n = size(truth%firings)
        first = 0
        last = 0
        if (n > 0) then
            first = truth%firings(1)%time
            last = truth%firings(n)%time
        end if
        do product = 1, 2
            call begin(folder, merge('THR1A', 'THR1B', product == 1), n, first, last, file, error)
            if (allocated(error)) return
            counts = 100000
            total = 0
            do i = 1, n
                on_time_of = 0
                on_time_of(PAIRS(:, truth%firings(i)%pair)) = ON_TIME
                counts = counts + merge(1, 0, on_time_of > 0)
                total = total + on_time_of
                time = truth%firings(i)%time
                if (product == 1) time = truth%obc_of_gps(time)
                call put_tag(file, folder, time)
                call put(file, 'thrust_count_1', counts)
                call put(file, 'on_time_1', on_time_of)
                call put(file, 'accum_dur_1', total)
                file%values(file%layout%qualflg) = merge(BRANCHES, 0, folder%grace_fo)
                call file%writer%record(file%values)
            end do
            call file%writer%commit(error)
            if (allocated(error)) return
        end do
    end subroutine write_thrusters

    !> MAS1B, the gas in both tanks, of which the firings take the same from each, and TNK1B, their state.
    subroutine write_tanks(truth, folder, error)
        type(level1_truth_t), intent(in) :: truth
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: EVERY = 60                   ! s
        real(dp), parameter :: GAS(2) = [13.4351_dp, 13.4565_dp]        ! kg
        real(dp), parameter :: USED = 0.7e-6_dp             ! kg of a tank by a firing: two of 10 mN for 50 ms at 70 s
        integer, parameter :: GAS_FLAG = int(b'11000000'), STATES = 7
        real(dp), parameter :: TANK(STATES) = [150.0_dp, 1.5_dp, 18.0_dp, 18.1_dp, 17.9_dp, 18.2_dp, 18.3_dp]  ! bar, deg C
        integer, parameter :: TANK_FLAGS(2) = [31, 127]     ! GRACE, GRACE-FO
        type(product_file_t) :: file
        integer :: k, n, number

        n = int(truth%orbit%duration/EVERY) + 1
        call begin(folder, 'MAS1B', n, 0.0_dp, (n - 1)*EVERY, file, error)
        if (allocated(error)) return
        do k = 0, n - 1
            call put_tag(file, folder, k*EVERY)
            file%values(file%layout%prod_flag) = GAS_FLAG
            call put(file, 'gas_mass_tnk1', GAS - USED*count(truth%firings%time < k*EVERY))
            call file%writer%record(file%values)
        end do
        call file%writer%commit(error)
        if (allocated(error)) return
        call begin(folder, 'TNK1B', 2*n, 0.0_dp, (n - 1)*EVERY, file, error)
        if (allocated(error)) return
        do k = 0, n - 1
            do number = 1, 2
                call put_tag(file, folder, k*EVERY)
                call put(file, 'tank_id', [real(number, dp)])
                file%values(file%layout%prod_flag) = TANK_FLAGS(merge(2, 1, folder%grace_fo))
                call put(file, 'tank_pres', TANK)
                call file%writer%record(file%values)
            end do
        end do
        call file%writer%commit(error)
    end subroutine write_tanks

    !> The sequence of events: CMCAL at each begin and end.
    subroutine write_events(truth, folder, error)
        type(level1_truth_t), intent(in) :: truth
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        integer :: i

        call file%open(folder%name//'/'//SOE_NAME, error)
        if (allocated(error)) return
        do i = 1, size(truth%orbit%spans)
            associate (span => truth%orbit%spans(i))
                call file%line(trim(seconds(span%start))//' CMCAL 1 1 start')
                call file%line(trim(seconds(span%start + span%duration))//' CMCAL 1 0 stop')
            end associate
        end do
        call file%line(trim(seconds(0.0_dp))//' VCM 3 0 0 0 before')
        call append(folder%written, SOE_NAME)
        call file%commit(error)

    contains

        function seconds(time) result(text)
            real(dp), intent(in) :: time    !! s from the beginning
            character(40) :: text

            write (text, '(f0.3, 1x, a)') real(folder%epoch, dp) + time, 'GRACE'//folder%satellite
        end function seconds
    end subroutine write_events

    !> What the operator says: mass, inertia with its error, gains as said.
    subroutine write_setup(truth, drawn, folder, error)
        type(level1_truth_t), intent(in) :: truth
        type(level1_errors_t), intent(in) :: drawn
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        type(level1_setup_t) :: setup
        type(settings_t) :: settings

        setup%mass = truth%orbit%case%satellite%mass
        setup%inertia = drawn%inertia_factor*truth%orbit%case%satellite%inertia
        setup%rod_gain = truth%orbit%settings%rod_gain
        call settings%comment('What the operator of the simulated satellite says')
        call describe_level1(settings, setup)
        call settings%save(folder%name//'/'//SETUP_NAME, error)
        if (.not. allocated(error)) call append(folder%written, SETUP_NAME)
    end subroutine write_setup

    !> What is true: numbers of the run, and a row a second.
    subroutine write_truth_files(truth, drawn, seed, run, folder, error)
        type(level1_truth_t), intent(in) :: truth
        type(level1_errors_t), intent(in) :: drawn
        integer(i8), intent(in) :: seed
        integer, intent(in) :: run
        type(folder_t), intent(inout) :: folder
        type(error_t), allocatable, intent(out) :: error

        character(*), parameter :: COLUMNS = 'gps_s,q1,q2,q3,q4,wx_rad_s,wy_rad_s,wz_rad_s,wdx_rad_s2,wdy_rad_s2,wdz_rad_s2,'// &
            'bx_tesla,by_tesla,bz_tesla,current_x_ma,current_y_ma,current_z_ma,ax_m_s2,ay_m_s2,az_m_s2'
        type(settings_t) :: settings
        type(csv_writer_t) :: file
        type(truth_point_t) :: point
        integer :: k

        call settings%comment('The truth of simulated Level-1 files: no estimator reads it')
        call describe_truth(settings, truth, drawn, seed, run)
        call settings%save(folder%name//'/'//TRUTH_NAMELIST, error)
        if (allocated(error)) return
        call append(folder%written, TRUTH_NAMELIST)
        call file%open(folder%name//'/'//TRUTH_TABLE, COLUMNS, [character(80) :: 'truth of simulated Level-1 files, body '// &
                       'axes SRF; a: at the proof mass', 'case '//truth%orbit%case%name], error)
        if (allocated(error)) return
        do k = 0, truth%orbit%duration - 1
            call truth%at(real(k, dp), point)
            call file%row([real(folder%epoch + k, dp), point%quaternion, point%rate, point%acceleration, point%field, &
                           point%current, point%sensed])
        end do
        call append(folder%written, TRUTH_TABLE)
        call append(folder%written, TRUTH_TABLE//SIDE_ENDING)
        call file%commit(error)
    end subroutine write_truth_files

    !> The numbers of a run, with the settings they were drawn by.
    subroutine describe_truth(settings, truth, drawn, seed, run)
        type(settings_t), intent(inout) :: settings
        type(level1_truth_t), intent(in) :: truth
        type(level1_errors_t), intent(in) :: drawn
        integer(i8), intent(in) :: seed
        integer, intent(in) :: run

        type(level1_truth_t) :: copy
        type(level1_errors_t) :: e
        integer :: number, i
        real(dp) :: seed_number

        copy = truth
        e = drawn
        number = run
        seed_number = real(seed, dp)
        call settings%group('truth', 'Of this run; SRF')
        call settings%real_value('seed', seed_number, -FULL_RANGE, FULL_RANGE, '')
        call settings%integer_value('run', number, 0, huge(number), '')
        call settings%real_values('offset_mm', copy%offset, -FULL_RANGE, FULL_RANGE, 'mm, d: from the centre of mass to the '// &
                                  'proof mass', MILLIMETRE)
        call settings%real_values('rod_gain', copy%gain, -FULL_RANGE, FULL_RANGE, 'A m^2/mA')
        call settings%real_value('inertia_said', e%inertia_factor, -FULL_RANGE, FULL_RANGE, 'by the true one')
        call settings%real_values('scale', e%scale, -FULL_RANGE, FULL_RANGE, 'of the accelerometer')
        call settings%real_values('angular_scale', e%angular_scale, -FULL_RANGE, FULL_RANGE, 'of its angular channels')
        do i = 1, 3
            call settings%real_values('leakage_rod_'//integer_text(i), e%leak(:, i), -FULL_RANGE, FULL_RANGE, &
                                      'm/s^2/mA, x, y, z')
            call settings%real_values('leakage_rate_rod_'//integer_text(i), e%leak_rate(:, i), -FULL_RANGE, FULL_RANGE, &
                                      'm/s^2/(mA/s), x, y, z')
        end do
        call settings%real_value('clock_offset', copy%clock_offset, -FULL_RANGE, FULL_RANGE, 's, GPS less receiver time at '// &
                                 'the beginning')
        call settings%end_group()
        call describe_level1_simulation(settings, copy%orbit%settings)
    end subroutine describe_truth
end module gracecg_level1_simulated_files
