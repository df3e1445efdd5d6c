!> What an estimator can tell of its fit besides the result: the series and covariances from which
!> gracecg_estimation_diagnostics judges a calibration. Kept only when it is asked for.
module gracecg_estimation_fit_record
    use gracecg_base_kinds, only: dp
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_attitude_fit, only: fitted_rotation_t
    use gracecg_estimation_offset_model, only: offset_matrix
    implicit none
    private
    public :: fit_record_t, record_samples, record_rotation, record_covariance
    public :: NOISE_SOURCES, STAR_CAMERA_NOISE, A_PRIORI_KNOWLEDGE

    integer, parameter :: NOISE_SOURCES = 5         !! Accelerometer x, y, z, star camera, a-priori knowledge
    integer, parameter :: STAR_CAMERA_NOISE = 4     !! Its place among the sources
    integer, parameter :: A_PRIORI_KNOWLEDGE = 5
    !! Its place: errors of what `optimal` and `sequential` know of parameters beforehand

    !> Series and covariances of one fit.
    type :: fit_record_t
        real(dp) :: interval = 0                    !! h of the accelerometer, s
        integer, allocatable :: epoch(:)
        !! k of each accelerometer sample, at t = k h, that the fit keeps on all three axes
        real(dp), allocatable :: residual(:, :)
        !! Observed minus fitted, the noise of the instrument left in: (3, samples), m/s^2
        real(dp), allocatable :: partials(:, :, :)  !! da/dd at each sample, (3, 3, samples), 1/s^2
        real(dp), allocatable :: angular_acceleration(:, :) !! Of the fit, body axes, (3, samples), rad/s^2
        character(12), allocatable :: names(:)      !! Of the parameters: d_x, d_y, d_z first
        real(dp), allocatable :: covariance(:, :)
        !! Of these parameters under the noise that the estimator takes for the true one, SI units; its
        !! first 3 x 3 block is that of the solution
        real(dp) :: covariance_by_source(3, 3, NOISE_SOURCES) = 0
        !! What of the offset's covariance comes from which noise, m^2; together the whole
        logical :: torque_checked = .false.    !! The torque was compared with the rotation seen
        real(dp) :: torque_factor = 1               !! Of the rods' torque that would fit best
        real(dp) :: torque_sigma = 0                !! Its standard deviation
        real(dp) :: attitude_misfit = 0
        !! RMS of the attitude's residuals in standard deviations of the star camera's noise; 0 when
        !! that noise is not known
    end type fit_record_t

contains

    !> Puts the accelerometer's series of a fit into a record.
    pure subroutine record_samples(data, kept, residual, offset_partials, omega_dot, record)
        type(fitting_data_t), intent(in) :: data
        logical, intent(in) :: kept(:)                      !! On all axes, (samples)
        real(dp), intent(in) :: residual(:, :)              !! (3, samples), m/s^2
        real(dp), intent(in) :: offset_partials(:, :, :)    !! (component of d, axis, samples), 1/s^2
        real(dp), intent(in) :: omega_dot(:, 0:)            !! Of the fit, (3, 0:n), rad/s^2
        type(fit_record_t), intent(inout) :: record

        integer, allocatable :: places(:)
        integer :: i

        places = pack([(i, i=1, size(kept))], kept)
        record%interval = data%interval
        record%epoch = data%accelerometer_epoch(places)
        record%residual = residual(:, places)
        allocate (record%partials(3, 3, size(places)), record%angular_acceleration(3, size(places)))
        do i = 1, size(places)
            record%partials(:, :, i) = transpose(offset_partials(:, :, places(i)))
            record%angular_acceleration(:, i) = omega_dot(:, record%epoch(i))
        end do
    end subroutine record_samples

    !> The same along a fitted rotation, of samples that are all kept.
    pure subroutine record_rotation(data, rotation, residuals, record)
        type(fitting_data_t), intent(in) :: data
        type(fitted_rotation_t), intent(in) :: rotation     !! Of the fit
        real(dp), intent(in) :: residuals(:)                !! x, y, z of each sample in turn, m/s^2
        type(fit_record_t), intent(inout) :: record

        real(dp) :: partials(3, 3, size(data%accelerometer_epoch))
        logical :: kept(size(data%accelerometer_epoch))
        integer :: i

        kept = .true.
        do i = 1, size(kept)
            associate (k => data%accelerometer_epoch(i))
                partials(:, :, i) = transpose(offset_matrix(rotation%omega(:, k), rotation%omega_dot(:, k)))
            end associate
        end do
        call record_samples(data, kept, reshape(residuals, [3, size(kept)]), partials, rotation%omega_dot, record)
    end subroutine record_rotation

    !> Puts the covariance of a fit into a record, that of the offset first.
    pure subroutine record_covariance(names, covariance, offset, by_source, record)
        character(*), intent(in) :: names(:)        !! Of the parameters
        real(dp), intent(in) :: covariance(:, :)    !! (parameters, parameters)
        integer, intent(in) :: offset(3)            !! Places of d among the parameters
        real(dp), intent(in) :: by_source(3, 3, NOISE_SOURCES)  !! Of the offset, m^2
        type(fit_record_t), intent(inout) :: record

        integer, allocatable :: order(:)
        integer :: i

        order = [offset, pack([(i, i=1, size(names))], [(all(offset /= i), i=1, size(names))])]
        record%names = names(order)
        record%covariance = covariance(order, order)
        record%covariance_by_source = by_source
    end subroutine record_covariance
end module gracecg_estimation_fit_record
