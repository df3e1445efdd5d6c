!> Preprocessing and interpolation of CSR-TM-00-01 section 4.5: star-camera quaternions turned to body
!> axes, freed of sign flips and normalised; quaternions and magnetic flux density interpolated to
!> the accelerometer's epochs.
module gracecg_preprocessing
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t, fail, number_text
    use gracecg_vectors, only: cross
    use gracecg_quaternion, only: quaternion_product, conjugate_quaternion, normalised
    use gracecg_torque_rods, only: dipole_moment
    use gracecg_observation_set, only: observation_set_t, check_observations
    implicit none
    private
    public :: fitting_data_t, interpolation_t, preprocess

    !> A value by linear interpolation: (1 - fraction) v(first) + fraction v(first + 1).
    type :: interpolation_t
        integer :: first = 1
        real(dp) :: fraction = 0
        logical :: supported = .true.   !! False in a gap or far outside of the samples
    end type interpolation_t

    !> What the estimators work on. Fitting epochs are t = k h, k = 0..n.
    type :: fitting_data_t
        integer :: steps = 0                            !! n
        real(dp) :: interval = 0                        !! h, s
        integer, allocatable :: accelerometer_epoch(:)  !! k of each accelerometer sample
        real(dp), allocatable :: acceleration(:, :)     !! (3, samples), m/s^2
        integer, allocatable :: attitude_epoch(:)       !! k of each attitude pseudo-observation
        real(dp), allocatable :: quaternion(:, :)       !! (4, pseudo-observations), inertial to body
        type(interpolation_t), allocatable :: attitude_source(:)    !! Where each comes from
        real(dp), allocatable :: star_quaternion(:, :)  !! (4, star samples) before interpolation
        real(dp), allocatable :: torque(:, :)           !! m x B at 0, h/2 ... n h: (3, 2n + 1), N m
    end type fitting_data_t

    !> A gap of more than so many sampling intervals is not bridged by interpolation.
    real(dp), parameter :: LONGEST_GAP = 2.5_dp

contains

    !> Prepares an observation set for estimation.
    !>
    !> Fails when the observations are refused by check_observations, when accelerometer times are
    !> not multiples of the sampling interval, or when the magnetometer leaves a gap.
    subroutine preprocess(observations, data, error)
        type(observation_set_t), intent(in) :: observations
        type(fitting_data_t), intent(out) :: data
        type(error_t), allocatable, intent(out) :: error

        call check_observations(observations, error)
        if (allocated(error)) return
        associate (setup => observations%setup)
            data%interval = setup%accelerometer_interval
            data%steps = nint(setup%duration/data%interval)
        end associate
        call take_accelerations(observations, data, error)
        if (allocated(error)) return
        call take_attitude(observations, data, error)
        if (allocated(error)) return
        call take_torque(observations, data, error)
    end subroutine preprocess

    !> Accelerometer samples with the index of their epoch.
    subroutine take_accelerations(observations, data, error)
        type(observation_set_t), intent(in) :: observations
        type(fitting_data_t), intent(inout) :: data
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        associate (times => observations%accelerometer_time)
            allocate (data%accelerometer_epoch(size(times)))
            data%accelerometer_epoch = nint(times/data%interval)
            do i = 1, size(times)
                if (abs(times(i) - data%accelerometer_epoch(i)*data%interval) > 0.01_dp*data%interval) then
                    call fail(error, 'accelerometer: time '//number_text(times(i))// &
                              ' s is not a multiple of the sampling interval '// &
                              number_text(data%interval)//' s')
                    return
                end if
                if (data%accelerometer_epoch(i) < 0 .or. data%accelerometer_epoch(i) > data%steps) then
                    call fail(error, 'accelerometer: time '//number_text(times(i))// &
                              ' s lies outside the arc of '//number_text(data%steps*data%interval)//' s')
                    return
                end if
            end do
        end associate
        data%acceleration = observations%acceleration
    end subroutine take_accelerations

    !> Steps 1 and 2 of 4.5 and the interpolation (4-38)-(4-44) of the quaternions.
    subroutine take_attitude(observations, data, error)
        type(observation_set_t), intent(in) :: observations
        type(fitting_data_t), intent(inout) :: data
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: times(:)
        real(dp) :: to_body(4), q(4)
        type(interpolation_t) :: source
        integer :: i, k, used

        associate (setup => observations%setup)
            times = pack(observations%star_camera_time, observations%star_camera_head == setup%camera)
            to_body = conjugate_quaternion(setup%mounting(:, setup%camera))
            allocate (data%star_quaternion(4, size(times)))
            used = 0
            do i = 1, size(observations%star_camera_time)
                if (observations%star_camera_head(i) /= setup%camera) cycle
                q = normalised(quaternion_product(to_body, observations%quaternion(:, i)))
                ! q and -q are one attitude: keep the sign of the neighbour, the guess's to begin with
                if (used == 0) then
                    if (dot_product(q, setup%guess_quaternion) < 0) q = -q
                else
                    if (dot_product(q, data%star_quaternion(:, used)) < 0) q = -q
                end if
                used = used + 1
                data%star_quaternion(:, used) = q
            end do

            allocate (data%attitude_epoch(data%steps), data%quaternion(4, data%steps))
            allocate (data%attitude_source(data%steps))
            used = 0
            do k = 1, data%steps
                source = interpolation_at(times, k*data%interval, setup%star_camera_interval)
                if (.not. source%supported) cycle
                used = used + 1
                data%attitude_epoch(used) = k
                data%attitude_source(used) = source
                data%quaternion(:, used) = normalised(interpolated(data%star_quaternion, source))
            end do
        end associate
        data%attitude_epoch = data%attitude_epoch(:used)
        data%attitude_source = data%attitude_source(:used)
        data%quaternion = data%quaternion(:, :used)
        if (used < 3) call fail(error, 'star camera: too few samples for an attitude')
    end subroutine take_attitude

    !> The magnetic torque m x B of the manoeuvre at every half step, with the interpolated field
    !> (4-39), (4-41), (4-43).
    subroutine take_torque(observations, data, error)
        type(observation_set_t), intent(in) :: observations
        type(fitting_data_t), intent(inout) :: data
        type(error_t), allocatable, intent(out) :: error

        type(interpolation_t) :: source
        real(dp) :: t
        integer :: j

        allocate (data%torque(3, 2*data%steps + 1))
        do j = 0, 2*data%steps
            t = j*data%interval/2
            source = interpolation_at(observations%magnetometer_time, t, &
                                      observations%setup%magnetometer_interval)
            if (.not. source%supported) then
                call fail(error, 'magnetometer: no samples near '//number_text(t)//' s')
                return
            end if
            data%torque(:, j + 1) = cross(dipole_moment(observations%setup%rods, t), &
                                          interpolated(observations%field, source))
        end do
    end subroutine take_torque

    !> Linear interpolation between the neighbours of t; before the first sample it extrapolates
    !> backwards (4-38), (4-39), after the last one it keeps the last value (4-42), (4-43).
    pure function interpolation_at(times, t, interval) result(source)
        real(dp), intent(in) :: times(:)    !! Increasing, s
        real(dp), intent(in) :: t           !! s
        real(dp), intent(in) :: interval    !! Nominal sampling interval, s
        type(interpolation_t) :: source

        integer :: n

        n = size(times)
        source%first = max(1, min(n - 1, count(times <= t)))
        associate (before => times(source%first), after => times(source%first + 1))
            source%fraction = min(1.0_dp, (t - before)/(after - before))
            source%supported = after - before <= LONGEST_GAP*interval .and. &
                               t >= times(1) - 1.01_dp*interval .and. t <= times(n) + 1.01_dp*interval
        end associate
    end function interpolation_at

    pure function interpolated(values, source) result(value)
        real(dp), intent(in) :: values(:, :)    !! (components, samples)
        type(interpolation_t), intent(in) :: source
        real(dp) :: value(size(values, 1))

        value = (1 - source%fraction)*values(:, source%first) + &
                source%fraction*values(:, source%first + 1)
    end function interpolated
end module gracecg_preprocessing
