!> What is filed and shown of an estimate from Level-1 data: the VCM1B record, the line of the SOE file, the trim commands; what
!> it leaves of the accelerations, over time and as a spectrum; and where each value that it uses is from: the setup by line or
!> default, the day's own products, or the data themselves.
module gracecg_level1_results
    use gracecg_level1_basics
    use gracecg_base_spectrum, only: power_spectrum, band_means, HANN
    use gracecg_environment_time, only: utc_text
    use gracecg_files_file, only: output_file_t, appended_file_t, check_writable
    use gracecg_level1_calibration, only: level1_calibration_t, middle_of, utc_at
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_outcome, only: level1_estimate_t, milliseconds, level1_solution_t, sigma_of
    use gracecg_level1_products, only: level1_layout_t, level1_layout, satellite_of_grace_fo
    use gracecg_level1_series, only: without_line
    use gracecg_level1_setup, only: level1_setup_t, origin_t
    use gracecg_level1_writer, only: level1_writer_t
    implicit none
    private
    public :: trim_command_t, trim_commands, write_vcm, write_event, write_offsets, residual_spectrum_t, &
        fitted_samples, find_spectrum, find_origins

    type :: trim_command_t
        !! One command to a trim mass
        integer :: axis = 0    !! 1, 2, 3: x, y, z of SRF
        integer :: steps = 0                    !! With its sign
        character(80) :: text = ''    !! The command in words
    end type trim_command_t

    real(dp), parameter :: STEPS_A_SECOND = 50  !! Of a trim mass: 0.125 mm/s in steps of 2.5 um

    type :: residual_spectrum_t
        !! Mean of the arcs, one-sided amplitude spectral densities
        real(dp), allocatable :: frequency(:)       !! Hz, from 0 on
        real(dp), allocatable :: density(:, :)      !! Axis, frequency, m/s^2/sqrt(Hz)
        real(dp), allocatable :: band_frequency(:)  !! Hz, of means over thirds of octaves
        real(dp), allocatable :: band_density(:, :) !! Axis, band, m/s^2/sqrt(Hz)
    end type residual_spectrum_t

contains

    !> The commands that move the CG by +d: steps = nint(change/step M/trim mass) on each axis, in commands of at most
    !> so many steps.
    subroutine trim_commands(setup, offset, commands)
        type(level1_setup_t), intent(in) :: setup
        real(dp), intent(in) :: offset(3)           !! d, m
        type(trim_command_t), allocatable, intent(out) :: commands(:)

        integer :: axis, left, now

        allocate (commands(0))
        do axis = 1, 3
            left = nint(offset(axis)/setup%trim_step*setup%mass/setup%trim_mass)
            do while (left /= 0)
                now = sign(min(abs(left), setup%trim_most), left)
                commands = [commands, trim_command_t(axis, now, 'axis '//AXES(axis)//', '//integer_text(abs(now))//' steps '// &
                    merge('POS', 'NEG', now > 0)//' ('//integer_text(nint(abs(now)/STEPS_A_SECOND))//' s)')]
                left = left - now
            end do
        end do
    end subroutine trim_commands

    !> Writes the CoM in SRF, -d, as a VCM1B file with one record.
    subroutine write_vcm(path, calibration, estimate, error)
        character(*), intent(in) :: path    !! Of the file
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(error_t), allocatable, intent(out) :: error

        type(level1_writer_t) :: writer
        type(level1_layout_t) :: layout
        type(level1_header_t) :: header
        real(dp) :: vector(3), values(7)

        call level1_layout('VCM1B', satellite_of_grace_fo(calibration%satellite), layout, error)
        if (allocated(error)) return
        vector = -estimate%solutions(1)%offset
        values(1) = anint(middle_of(calibration))
        values(2) = iachar(calibration%satellite)
        values(3) = norm2(vector)
        values(4:6) = vector/max(norm2(vector), tiny(1.0_dp))
        values(7) = 0
        header%satellite = calibration%satellite
        header%records = 1
        header%first_time = values(1)
        header%last_time = values(1)
        call writer%open(path, layout, .false., header, error)
        if (allocated(error)) return
        call writer%record(values)
        call writer%commit(error)
    end subroutine write_vcm

    !> Adds the CoM as a VCM event to a file of events, which is made where there is none. Fails when it is an input.
    subroutine write_event(path, calibration, estimate, error)
        character(*), intent(in) :: path    !! Of the file
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(error_t), allocatable, intent(out) :: error

        type(appended_file_t) :: file

        call check_writable(path, error)
        if (.not. allocated(error)) call file%open(path, error)
        if (allocated(error)) return
        associate (d => estimate%solutions(1)%offset)
            call file%line(integer_text(nint(middle_of(calibration), i8))//' GRACE'//calibration%satellite//' VCM 3 '// &
                           real_text(-d(1))//' '//real_text(-d(2))//' '//real_text(-d(3))//' by gracecg, source '// &
                           trim(estimate%solutions(1)%source)//', flag '//integer_text(estimate%flag), error)
        end associate
    end subroutine write_event

    !> Writes the offset by each span that determines it, as CSV: the middle of the span, d and its standard deviations.
    subroutine write_offsets(path, calibration, solution, error)
        character(*), intent(in) :: path    !! Of the file
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_solution_t), intent(in) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: line
        real(dp) :: values(6)
        integer :: i, k

        call file%open(path, error)
        if (allocated(error)) return
        call file%line('time_utc,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm')
        do i = 1, size(calibration%spans)
            if (.not. solution%span_covariance(1, 1, i) > 0) cycle
            line = trim(utc_text(utc_at(calibration, (calibration%spans(i)%start + calibration%spans(i)%stop)/2)))
            values = [solution%span_offset(:, i), sigma_of(solution, i)]/MILLIMETRE
            do k = 1, size(values)
                line = line//','//real_text(values(k))
            end do
            call file%line(line)
        end do
        call file%commit(error)
    end subroutine write_offsets

    !> Samples of an arc that the fit kept: their times, observed without bias and drift, and residuals.
    pure subroutine fitted_samples(estimate, arc, time, observed, residual)
        type(level1_estimate_t), intent(in) :: estimate
        integer, intent(in) :: arc                              !! Its number
        real(dp), allocatable, intent(out) :: time(:)           !! s from the begin of the arc
        real(dp), allocatable, intent(out) :: observed(:, :)    !! (3, n), m/s^2
        real(dp), allocatable, intent(out) :: residual(:, :)    !! Likewise

        integer, allocatable :: place(:), kept(:)
        integer :: axis, k

        associate (set => estimate%arcs(arc), left => estimate%residuals(arc))
            place = nint(set%accelerometer_time/set%knowledge%accelerometer_interval) + 1
            kept = pack([(k, k=1, size(place))], left%kept(place))
            time = set%accelerometer_time(kept)
            observed = set%acceleration(:, kept)
            residual = left%linear(:, place(kept))
        end associate
        do axis = 1, 3
            observed(axis, :) = without_line(time, observed(axis, :))
        end do
    end subroutine fitted_samples

    !> The spectrum of the residuals of all arcs, in segments as long as the shortest.
    subroutine find_spectrum(estimate, spectrum)
        type(level1_estimate_t), intent(in) :: estimate
        type(residual_spectrum_t), intent(out) :: spectrum

        real(dp), parameter :: BAND = 1/3.0_dp      ! Octaves
        real(dp), allocatable :: time(:), observed(:, :), residual(:, :), density(:), means(:), power(:, :)
        integer :: i, axis, longest

        longest = huge(longest)
        do i = 1, size(estimate%arcs)       ! samples at an end may be left out
            call fitted_samples(estimate, i, time, observed, residual)
            longest = min(longest, nint((time(size(time)) - time(1))/estimate%arcs(i)%knowledge%accelerometer_interval) + 1)
        end do
        do i = 1, size(estimate%arcs)
            call fitted_samples(estimate, i, time, observed, residual)
            associate (interval => estimate%arcs(i)%knowledge%accelerometer_interval)
                do axis = 1, 3
                    call power_spectrum(nint((time - time(1))/interval), residual(axis, :), interval, longest, HANN, &
                                        spectrum%frequency, density)
                    if (.not. allocated(power)) allocate (power(3, size(density)), source=0.0_dp)
                    power(axis, :) = power(axis, :) + 2*density/size(estimate%arcs)
                end do
            end associate
        end do
        do axis = 1, 3
            call band_means(spectrum%frequency, power(axis, :), BAND, spectrum%band_frequency, means)
            if (.not. allocated(spectrum%band_density)) allocate (spectrum%band_density(3, size(means)))
            spectrum%band_density(axis, :) = sqrt(means)
        end do
        spectrum%density = sqrt(power)
    end subroutine find_spectrum

    !> All values with their sources.
    subroutine find_origins(calibration, estimate, origins)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(origin_t), allocatable, intent(out) :: origins(:)

        integer :: i, axis
        character(80) :: noise

        allocate (origins(0))
        if (allocated(calibration%setup%origins)) origins = calibration%setup%origins
        do i = 1, size(origins)
            if (origins(i)%name == 'mass' .and. calibration%mass > 0) then
                origins(i)%value = real_text(calibration%mass)
                origins(i)%source = source_of('MAS1')
            end if
        end do
        if (allocated(calibration%products)) origins = [origins, calibration%products]
        call add('firings', integer_text(sum(calibration%spans%firings_inside)), 'in the spans', source_of('THR1'))
        if (all(calibration%gas > 0)) call add('gas', real_text(calibration%gas(1))//', '//real_text(calibration%gas(2)), &
                                               'kg, in tanks 1 and 2', source_of('MAS1'))
        call add('field', '', 'of the Earth', 'IGRF-14')
        if (calibration%setup%field_file /= '') origins(size(origins))%source = calibration%setup%field_file
        noise = ''
        do axis = 1, 3
            noise = trim(noise)//' '//rounded_text(estimate%solutions(1)%rms(axis), 3)
        end do
        call add('noise', adjustl(noise), 'm/s^2, of the accelerometer, x, y, z', 'residuals of the fit')
        call add('torque_delay_estimated', trim(milliseconds(estimate%rods%delay)), 'ms', 'the fit')
        if (estimate%accelerometer_delay_sigma > 0) call add('accelerometer_delay_estimated', &
            trim(milliseconds(estimate%accelerometer_delay)), 'ms', 'the fit')

    contains

        subroutine add(name, value, meaning, source)
            character(*), intent(in) :: name, value, meaning, source

            origins = [origins, origin_t(name, value, meaning, source)]
        end subroutine add

        !> The files of a product, 1A or 1B.
        function source_of(product) result(source)
            character(4), intent(in) :: product
            character(200) :: source

            integer :: k

            source = 'no file'
            if (.not. allocated(calibration%products)) return
            do k = 1, size(calibration%products)
                if (calibration%products(k)%name(:4) == product) source = calibration%products(k)%source
            end do
        end function source_of
    end subroutine find_origins
end module gracecg_level1_results
