!> Where each value that an estimate from Level-1 files uses is from: the setup by line or default, the day's own products, or the
!> data themselves.
module gracecg_level1_origins
    use gracecg_base_text, only: integer_text, real_text, rounded_text
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_outcome, only: level1_estimate_t, milliseconds
    use gracecg_level1_setup, only: level1_setup_t, origin_t
    implicit none
    private
    public :: take_from_products, find_origins

contains

    !> Takes the mass from the day's MAS1B, where that has it, in place of the setup's.
    pure subroutine take_from_products(calibration, setup)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(inout) :: setup

        if (calibration%mass > 0) setup%mass = calibration%mass
    end subroutine take_from_products

    !> All values with their sources.
    subroutine find_origins(calibration, setup, estimate, origins)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(in) :: estimate
        type(origin_t), allocatable, intent(out) :: origins(:)

        integer :: i, axis
        character(80) :: noise

        allocate (origins(0))
        if (allocated(setup%origins)) origins = setup%origins
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
        if (setup%field_file /= '') origins(size(origins))%source = setup%field_file
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
end module gracecg_level1_origins
